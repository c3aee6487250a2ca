"""Sensors."""

from .camera import Camera, CameraCfg, TiledCamera, TiledCameraCfg
from .contact_sensor import ContactSensor, ContactSensorCfg, ContactSensorData
from .frame_transformer import FrameTransformer, FrameTransformerCfg, FrameTransformerData, OffsetCfg
from .imu import Imu, ImuCfg, ImuData
from .ray_caster import (
    MultiMeshRayCasterCameraCfg,
    MultiMeshRayCasterCfg,
    RayCaster,
    RayCasterCamera,
    RayCasterCameraCfg,
    RayCasterCfg,
    patterns,
)
from .sensor_base import SensorBase
from .sensor_base_cfg import SensorBaseCfg

__all__ = [
    "Camera",
    "CameraCfg",
    "ContactSensor",
    "ContactSensorCfg",
    "ContactSensorData",
    "FrameTransformer",
    "FrameTransformerCfg",
    "FrameTransformerData",
    "Imu",
    "ImuCfg",
    "ImuData",
    "MultiMeshRayCasterCameraCfg",
    "MultiMeshRayCasterCfg",
    "OffsetCfg",
    "RayCaster",
    "RayCasterCamera",
    "RayCasterCameraCfg",
    "RayCasterCfg",
    "SensorBase",
    "SensorBaseCfg",
    "TiledCamera",
    "TiledCameraCfg",
    "patterns",
]
