"""A Haply haptic device: config only."""

from __future__ import annotations

from lift_lab.utils import configclass

from ..device_base import DeviceBase, DeviceCfg


class HaplyDevice(DeviceBase):
    """A type for configs; making one raises."""


@configclass
class HaplyDeviceCfg(DeviceCfg):
    """A Haply haptic device: accepted as data."""

    class_type: type[DeviceBase] | None = HaplyDevice
    websocket_uri: str = "ws://localhost:10001"
    pos_sensitivity: float = 1.0
    data_rate: float = 200.0
    limit_force: float = 2.0
