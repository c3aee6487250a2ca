"""Cameras: configs only."""

from .camera import Camera
from .camera_cfg import CameraCfg
from .tiled_camera import TiledCamera
from .tiled_camera_cfg import TiledCameraCfg

__all__ = ["Camera", "CameraCfg", "TiledCamera", "TiledCameraCfg"]
