"""Making a device from an environment's configs (Isaac Lab's ``create_teleop_device``)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from lift_lab.utils.errors import ConfigError, NotFoundError, suggest

from .device_base import DeviceBase, DeviceCfg


def create_teleop_device(
    device_name: str,
    devices_cfg: Mapping[str, DeviceCfg],
    callbacks: Mapping[str, Callable[[], Any]] | None = None,
) -> DeviceBase:
    """Refuse to make the device ``device_name``.

    Raises:
        NotFoundError: there is no config of that name.
        ConfigError: always otherwise.
    """
    if device_name not in devices_cfg:
        raise NotFoundError(f"no teleoperation device '{device_name}'; {suggest(device_name, devices_cfg)}")
    raise ConfigError(f"'{device_name}': teleoperation devices are not supported")
