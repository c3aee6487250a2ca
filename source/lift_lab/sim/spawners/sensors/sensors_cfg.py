"""Camera configs, data only: cameras are not simulated, and a scene that holds one says so."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Literal

from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, POSITIVE, POSITIVE_SPAN_OR_INF, Ranges

from ..spawner_cfg import Spawned, SpawnerCfg


def spawn_camera(prim_path: str, cfg: PinholeCameraCfg) -> Spawned:
    """Refuse to spawn a camera: image sensors are not part of lift_lab.

    Raises:
        ConfigError: always.
    """
    raise ConfigError(f"{prim_path}: camera sensors are not supported; remove {type(cfg).__name__} from the scene")


@configclass
class PinholeCameraCfg(SpawnerCfg):
    """A pinhole camera (lengths in tenths of a scene unit, as USD has them)."""

    func: Callable = spawn_camera
    projection_type: str = "pinhole"
    clipping_range: tuple[float, float] = (0.01, 1e6)
    focal_length: float = 24.0
    focus_distance: float = 400.0
    f_stop: float = 0.0
    horizontal_aperture: float = 20.955
    vertical_aperture: float | None = None
    horizontal_aperture_offset: float = 0.0
    vertical_aperture_offset: float = 0.0
    lock_camera: bool = True

    _ranges: ClassVar[Ranges] = {
        "clipping_range": POSITIVE_SPAN_OR_INF,
        "focal_length horizontal_aperture vertical_aperture": POSITIVE,
        "focus_distance f_stop": NOT_NEGATIVE,
        "horizontal_aperture_offset vertical_aperture_offset": FINITE,
    }


@configclass
class FisheyeCameraCfg(PinholeCameraCfg):
    """A fisheye camera."""

    projection_type: Literal["fisheyePolynomial", "fisheyeSpherical", "omniDirectionalStereo"] = "fisheyePolynomial"
    fisheye_nominal_width: float = 1936.0
    fisheye_nominal_height: float = 1216.0
    fisheye_optical_centre_x: float = 970.94244
    fisheye_optical_centre_y: float = 600.37482
    fisheye_max_fov: float = 200.0

    _ranges: ClassVar[Ranges] = {
        "fisheye_nominal_width fisheye_nominal_height fisheye_max_fov": POSITIVE,
        "fisheye_optical_centre_x fisheye_optical_centre_y": FINITE,
    }
