"""Haply devices: configs only."""

from .se3_haply import HaplyDevice, HaplyDeviceCfg

__all__ = [
    "HaplyDevice",
    "HaplyDeviceCfg",
]
