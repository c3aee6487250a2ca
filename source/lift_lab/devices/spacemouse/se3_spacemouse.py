"""A space mouse that moves an end effector: config only."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, Ranges

from ..device_base import DeviceBase, DeviceCfg


class Se3SpaceMouse(DeviceBase):
    """A type for configs; making one raises."""


@configclass
class Se3SpaceMouseCfg(DeviceCfg):
    """A space mouse that moves an end effector: accepted as data."""

    class_type: type[DeviceBase] | None = Se3SpaceMouse
    gripper_term: bool = True
    pos_sensitivity: float = 0.4
    rot_sensitivity: float = 0.8

    _ranges: ClassVar[Ranges] = {"pos_sensitivity rot_sensitivity": FINITE}
