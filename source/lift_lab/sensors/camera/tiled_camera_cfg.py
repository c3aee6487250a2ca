"""Config of a tiled camera (data only)."""

from __future__ import annotations

from lift_lab.utils import configclass

from .camera_cfg import CameraCfg
from .tiled_camera import TiledCamera


@configclass
class TiledCameraCfg(CameraCfg):
    """A tiled camera: accepted as data; building a scene with one raises."""

    class_type: type = TiledCamera
