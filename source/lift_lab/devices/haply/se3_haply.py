"""A Haply haptic device: config only."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, POSITIVE, Ranges

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

    _ranges: ClassVar[Ranges] = {"pos_sensitivity": FINITE, "data_rate": POSITIVE, "limit_force": NOT_NEGATIVE}
