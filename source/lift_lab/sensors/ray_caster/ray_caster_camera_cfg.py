"""Config of a camera of cast rays (data only)."""

from __future__ import annotations

from dataclasses import MISSING
from typing import ClassVar, Literal

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, Ranges

from .patterns import PinholeCameraPatternCfg
from .ray_caster_camera import RayCasterCamera
from .ray_caster_cfg import RayCasterCfg


@configclass
class RayCasterCameraCfg(RayCasterCfg):
    """A camera of cast rays: accepted as data; building a scene with one raises."""

    @configclass
    class OffsetCfg:
        """Pose of the camera relative to its parent."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
        convention: Literal["opengl", "ros", "world"] = "ros"

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = RayCasterCamera
    offset: OffsetCfg = OffsetCfg()
    data_types: list[str] = ["distance_to_image_plane"]
    depth_clipping_behavior: Literal["max", "zero", "none"] = "none"
    pattern_cfg: PinholeCameraPatternCfg = MISSING
