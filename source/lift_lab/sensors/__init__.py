"""Sensors."""

from .camera import Camera, CameraCfg, TiledCamera, TiledCameraCfg
from .contact_sensor import ContactSensor, ContactSensorCfg
from .frame_transformer import FrameTransformer, FrameTransformerCfg, FrameTransformerData, OffsetCfg
from .sensor_base import SensorBase
from .sensor_base_cfg import SensorBaseCfg

__all__ = [
    "Camera",
    "CameraCfg",
    "ContactSensor",
    "ContactSensorCfg",
    "FrameTransformer",
    "FrameTransformerCfg",
    "FrameTransformerData",
    "OffsetCfg",
    "SensorBase",
    "SensorBaseCfg",
    "TiledCamera",
    "TiledCameraCfg",
]
