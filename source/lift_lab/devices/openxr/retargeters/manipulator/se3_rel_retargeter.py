"""A hand's motion as an end effector's motion: config only."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, FRACTION, Ranges

from ....device_base import DeviceBase
from ....retargeter_base import RetargeterBase, RetargeterCfg


class Se3RelRetargeter(RetargeterBase):
    """A type for configs; making one raises."""


@configclass
class Se3RelRetargeterCfg(RetargeterCfg):
    """A hand's motion as an end effector's motion: accepted as data."""

    retargeter_type: type[RetargeterBase] | None = Se3RelRetargeter
    bound_hand: DeviceBase.TrackingTarget = DeviceBase.TrackingTarget.HAND_RIGHT
    zero_out_xy_rotation: bool = True
    use_wrist_rotation: bool = False
    use_wrist_position: bool = True
    delta_pos_scale_factor: float = 10.0
    delta_rot_scale_factor: float = 10.0
    alpha_pos: float = 0.5
    alpha_rot: float = 0.5
    enable_visualization: bool = False

    _ranges: ClassVar[Ranges] = {
        "delta_pos_scale_factor delta_rot_scale_factor": FINITE,
        "alpha_pos alpha_rot": FRACTION,
    }
