"""Camera configs (data only)."""

from .sensors_cfg import FisheyeCameraCfg, PinholeCameraCfg

__all__ = ["FisheyeCameraCfg", "PinholeCameraCfg"]
