"""A pinch as a gripper command: config only."""

from __future__ import annotations

from lift_lab.utils import configclass

from ....device_base import DeviceBase
from ....retargeter_base import RetargeterBase, RetargeterCfg


class GripperRetargeter(RetargeterBase):
    """A type for configs; making one raises."""


@configclass
class GripperRetargeterCfg(RetargeterCfg):
    """A pinch as a gripper command: accepted as data."""

    retargeter_type: type[RetargeterBase] | None = GripperRetargeter
    bound_hand: DeviceBase.TrackingTarget = DeviceBase.TrackingTarget.HAND_RIGHT
