"""Cameras: configs only."""

from __future__ import annotations

from dataclasses import MISSING
from typing import Literal

from lift_lab.sim.spawners.sensors import FisheyeCameraCfg, PinholeCameraCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError

from ..sensor_base import SensorBase
from ..sensor_base_cfg import SensorBaseCfg


class Camera(SensorBase):
    """A type for configs; making one raises."""

    def __init__(self, cfg: SensorBaseCfg):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"'{cfg.prim_path}': image sensors are not simulated; remove the camera from the scene")

    @property
    def data(self) -> None:
        """There is none."""


class TiledCamera(Camera):
    """A type for configs; making one raises."""


@configclass
class CameraCfg(SensorBaseCfg):
    """A camera: accepted as data; building a scene with one raises."""

    @configclass
    class OffsetCfg:
        """Pose of the camera relative to its parent."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
        convention: Literal["opengl", "ros", "world"] = "ros"

    class_type: type = Camera
    offset: OffsetCfg = OffsetCfg()
    spawn: PinholeCameraCfg | FisheyeCameraCfg | None = MISSING
    depth_clipping_behavior: Literal["max", "zero", "none"] = "none"
    data_types: list[str] = ["rgb"]
    width: int = MISSING
    height: int = MISSING
    update_latest_camera_pose: bool = False


@configclass
class TiledCameraCfg(CameraCfg):
    """A tiled camera: accepted as data; building a scene with one raises."""

    class_type: type = TiledCamera


__all__ = ["Camera", "CameraCfg", "TiledCamera", "TiledCameraCfg"]
