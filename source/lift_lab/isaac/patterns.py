"""Patterns of rays. Lengths in m, angles in degrees."""

from typing import ClassVar, Literal

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import COUNT, FINITE, NOT_NEGATIVE, POSITIVE, SPAN, Ranges

from .finder import place


@configclass
class PatternBaseCfg(ConfigBase):
    """Base of ray patterns."""


@configclass
class GridPatternCfg(PatternBaseCfg):
    """Parallel rays from a grid."""

    resolution: float = MISSING
    size: tuple[float, float] = MISSING
    direction: tuple[float, float, float] = (0.0, 0.0, -1.0)
    ordering: Literal["xy", "yx"] = "xy"

    _ranges: ClassVar[Ranges] = {"resolution": POSITIVE, "size": NOT_NEGATIVE, "direction": FINITE}


@configclass
class PinholeCameraPatternCfg(PatternBaseCfg):
    """The rays of a pinhole camera."""

    focal_length: float = 24.0
    horizontal_aperture: float = 20.955
    vertical_aperture: float | None = None
    horizontal_aperture_offset: float = 0.0
    vertical_aperture_offset: float = 0.0
    width: int = MISSING
    height: int = MISSING

    _ranges: ClassVar[Ranges] = {
        "focal_length horizontal_aperture vertical_aperture": POSITIVE,
        "horizontal_aperture_offset vertical_aperture_offset": FINITE,
        "width height": COUNT,
    }


@configclass
class LidarPatternCfg(PatternBaseCfg):
    """The rays of a spinning lidar."""

    channels: int = MISSING
    vertical_fov_range: tuple[float, float] = MISSING
    horizontal_fov_range: tuple[float, float] = MISSING
    horizontal_res: float = MISSING

    _ranges: ClassVar[Ranges] = {
        "channels": COUNT,
        "vertical_fov_range horizontal_fov_range": SPAN,
        "horizontal_res": POSITIVE,
    }


@configclass
class BpearlPatternCfg(PatternBaseCfg):
    """The rays of a RS-Bpearl lidar."""

    horizontal_fov: float = 360.0
    horizontal_res: float = 10.0
    vertical_ray_angles: list[float] = [89.5 - 2.8125 * i for i in range(32)]

    _ranges: ClassVar[Ranges] = {"horizontal_fov horizontal_res": POSITIVE, "vertical_ray_angles": FINITE}


place(__name__)
