"""A gamepad that drives a mobile base: config only."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, Ranges

from ..device_base import DeviceBase, DeviceCfg


class Se2Gamepad(DeviceBase):
    """A type for configs; making one raises."""


@configclass
class Se2GamepadCfg(DeviceCfg):
    """A gamepad that drives a mobile base: accepted as data."""

    class_type: type[DeviceBase] | None = Se2Gamepad
    v_x_sensitivity: float = 1.0
    v_y_sensitivity: float = 1.0
    omega_z_sensitivity: float = 1.0
    dead_zone: float = 0.01

    _ranges: ClassVar[Ranges] = {
        "v_x_sensitivity v_y_sensitivity omega_z_sensitivity": FINITE,
        "dead_zone": NOT_NEGATIVE,
    }
