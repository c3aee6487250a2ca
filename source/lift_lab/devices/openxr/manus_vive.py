"""Manus gloves with Vive trackers: config only."""

from __future__ import annotations

from lift_lab.utils import configclass

from ..device_base import DeviceBase, DeviceCfg
from .xr_cfg import XrCfg


class ManusVive(DeviceBase):
    """A type for configs; making one raises."""


@configclass
class ManusViveCfg(DeviceCfg):
    """Manus gloves with Vive trackers: accepted as data."""

    class_type: type[DeviceBase] | None = ManusVive
    xr_cfg: XrCfg | None = None
