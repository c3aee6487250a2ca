"""Config of a ray caster (data only)."""

from __future__ import annotations

from dataclasses import MISSING
from typing import ClassVar, Literal

from lift_lab.markers import RAY_CASTER_MARKER_CFG, VisualizationMarkersCfg
from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, POSITIVE_OR_INF, Ranges

from ..sensor_base_cfg import SensorBaseCfg
from .patterns import PatternBaseCfg
from .ray_caster import RayCaster


@configclass
class RayCasterCfg(SensorBaseCfg):
    """Rays against meshes: accepted as data; building a scene with one raises."""

    @configclass
    class OffsetCfg:
        """Pose of the rays' frame relative to the body's."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = RayCaster
    mesh_prim_paths: list[str] = MISSING
    offset: OffsetCfg = OffsetCfg()
    attach_yaw_only: bool | None = None
    ray_alignment: Literal["base", "yaw", "world"] = "base"
    pattern_cfg: PatternBaseCfg = MISSING
    max_distance: float = 1e6
    drift_range: tuple[float, float] = (0.0, 0.0)
    ray_cast_drift_range: dict[str, tuple[float, float]] = {"x": (0.0, 0.0), "y": (0.0, 0.0), "z": (0.0, 0.0)}
    visualizer_cfg: VisualizationMarkersCfg = RAY_CASTER_MARKER_CFG.replace(prim_path="/Visuals/RayCaster")

    _ranges: ClassVar[Ranges] = {"max_distance": POSITIVE_OR_INF, "drift_range ray_cast_drift_range": FINITE}
