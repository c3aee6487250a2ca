"""A keyboard that drives a mobile base: config only."""

from __future__ import annotations

from lift_lab.utils import configclass

from ..device_base import DeviceBase, DeviceCfg


class Se2Keyboard(DeviceBase):
    """A type for configs; making one raises."""


@configclass
class Se2KeyboardCfg(DeviceCfg):
    """A keyboard that drives a mobile base: accepted as data."""

    class_type: type[DeviceBase] | None = Se2Keyboard
    v_x_sensitivity: float = 0.8
    v_y_sensitivity: float = 0.4
    omega_z_sensitivity: float = 1.0
