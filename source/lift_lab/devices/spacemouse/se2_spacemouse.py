"""A space mouse that drives a mobile base: config only."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, Ranges

from ..device_base import DeviceBase, DeviceCfg


class Se2SpaceMouse(DeviceBase):
    """A type for configs; making one raises."""


@configclass
class Se2SpaceMouseCfg(DeviceCfg):
    """A space mouse that drives a mobile base: accepted as data."""

    class_type: type[DeviceBase] | None = Se2SpaceMouse
    v_x_sensitivity: float = 0.8
    v_y_sensitivity: float = 0.4
    omega_z_sensitivity: float = 1.0

    _ranges: ClassVar[Ranges] = {"v_x_sensitivity v_y_sensitivity omega_z_sensitivity": FINITE}
