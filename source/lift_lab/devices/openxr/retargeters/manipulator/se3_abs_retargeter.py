"""A hand's pose as an end effector's pose: config only."""

from __future__ import annotations

from lift_lab.utils import configclass

from ....device_base import DeviceBase
from ....retargeter_base import RetargeterBase, RetargeterCfg


class Se3AbsRetargeter(RetargeterBase):
    """A type for configs; making one raises."""


@configclass
class Se3AbsRetargeterCfg(RetargeterCfg):
    """A hand's pose as an end effector's pose: accepted as data."""

    retargeter_type: type[RetargeterBase] | None = Se3AbsRetargeter
    bound_hand: DeviceBase.TrackingTarget = DeviceBase.TrackingTarget.HAND_RIGHT
    zero_out_xy_rotation: bool = True
    use_wrist_rotation: bool = False
    use_wrist_position: bool = True
    enable_visualization: bool = False
