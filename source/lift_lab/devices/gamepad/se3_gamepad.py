"""A gamepad that moves an end effector: config only."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, Ranges

from ..device_base import DeviceBase, DeviceCfg


class Se3Gamepad(DeviceBase):
    """A type for configs; making one raises."""


@configclass
class Se3GamepadCfg(DeviceCfg):
    """A gamepad that moves an end effector: accepted as data."""

    class_type: type[DeviceBase] | None = Se3Gamepad
    gripper_term: bool = True
    dead_zone: float = 0.01
    pos_sensitivity: float = 1.0
    rot_sensitivity: float = 1.6

    _ranges: ClassVar[Ranges] = {"dead_zone": NOT_NEGATIVE, "pos_sensitivity rot_sensitivity": FINITE}
