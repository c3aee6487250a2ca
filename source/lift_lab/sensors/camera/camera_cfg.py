"""Config of a camera (data only)."""

from __future__ import annotations

from dataclasses import MISSING
from typing import ClassVar, Literal

from lift_lab.sim.spawners.sensors import FisheyeCameraCfg, PinholeCameraCfg
from lift_lab.utils import configclass
from lift_lab.utils.ranges import COUNT, COUNT_OR_ZERO, FINITE, Ranges

from ..sensor_base_cfg import SensorBaseCfg
from .camera import Camera


@configclass
class CameraCfg(SensorBaseCfg):
    """A camera: accepted as data; building a scene with one raises."""

    @configclass
    class OffsetCfg:
        """Pose of the camera relative to its parent."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
        convention: Literal["opengl", "ros", "world"] = "ros"

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = Camera
    offset: OffsetCfg = OffsetCfg()
    spawn: PinholeCameraCfg | FisheyeCameraCfg | None = MISSING
    depth_clipping_behavior: Literal["max", "zero", "none"] = "none"
    data_types: list[str] = ["rgb"]
    width: int = MISSING
    height: int = MISSING
    update_latest_camera_pose: bool = False
    semantic_filter: str | list[str] = "*:*"
    colorize_semantic_segmentation: bool = True
    colorize_instance_id_segmentation: bool = True
    colorize_instance_segmentation: bool = True
    semantic_segmentation_mapping: dict[str, tuple[int, int, int, int]] = {}

    _ranges: ClassVar[Ranges] = {"width height": COUNT, "semantic_segmentation_mapping": COUNT_OR_ZERO}
