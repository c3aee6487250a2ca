"""A headset or hand tracker over OpenXR: config only."""

from __future__ import annotations

from lift_lab.utils import configclass

from ..device_base import DeviceBase, DeviceCfg
from .xr_cfg import XrCfg


class OpenXRDevice(DeviceBase):
    """A type for configs; making one raises."""


@configclass
class OpenXRDeviceCfg(DeviceCfg):
    """A headset or hand tracker over OpenXR: accepted as data."""

    class_type: type[DeviceBase] | None = OpenXRDevice
    xr_cfg: XrCfg | None = None
