"""What all teleoperation devices share (names of Isaac Lab's): configs hold data, making a device raises."""

from __future__ import annotations

from enum import Enum

from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError

from .retargeter_base import RetargeterBase, RetargeterCfg


class DeviceBase:
    """A type for configs and annotations; making one raises."""

    class TrackingTarget(Enum):
        """What a tracking device follows."""

        HAND_LEFT = 0
        HAND_RIGHT = 1
        HEAD = 2
        CONTROLLER_LEFT = 3
        CONTROLLER_RIGHT = 4

    def __init__(self, cfg: DeviceCfg | None = None, retargeters: list[RetargeterBase] | None = None):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"{type(self).__name__}: teleoperation devices are not supported")


@configclass
class DeviceCfg:
    """Base of device configs."""

    class_type: type[DeviceBase] | None = None
    """The device."""
    teleoperation_active_default: bool = True
    """Whether teleoperation starts switched on."""
    sim_device: str = "cpu"
    """Torch device of the commands."""
    retargeters: list[RetargeterCfg] | None = []
    """What turns the device's data into robot commands."""


@configclass
class DevicesCfg:
    """The teleoperation devices of an environment, by name."""

    devices: dict[str, DeviceCfg] = {}
