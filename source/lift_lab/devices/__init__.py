"""Teleoperation devices, as configs that Isaac Lab's task files name. None can be made: see DeviceBase."""

from .device_base import DeviceBase, DeviceCfg, DevicesCfg
from .gamepad import Se2Gamepad, Se2GamepadCfg, Se3Gamepad, Se3GamepadCfg
from .haply import HaplyDevice, HaplyDeviceCfg
from .keyboard import Se2Keyboard, Se2KeyboardCfg, Se3Keyboard, Se3KeyboardCfg
from .openxr import ManusVive, ManusViveCfg, OpenXRDevice, OpenXRDeviceCfg
from .retargeter_base import RetargeterBase, RetargeterCfg
from .spacemouse import Se2SpaceMouse, Se2SpaceMouseCfg, Se3SpaceMouse, Se3SpaceMouseCfg
from .teleop_device_factory import create_teleop_device

__all__ = [
    "DeviceBase",
    "DeviceCfg",
    "DevicesCfg",
    "HaplyDevice",
    "HaplyDeviceCfg",
    "ManusVive",
    "ManusViveCfg",
    "OpenXRDevice",
    "OpenXRDeviceCfg",
    "RetargeterBase",
    "RetargeterCfg",
    "Se2Gamepad",
    "Se2GamepadCfg",
    "Se2Keyboard",
    "Se2KeyboardCfg",
    "Se2SpaceMouse",
    "Se2SpaceMouseCfg",
    "Se3Gamepad",
    "Se3GamepadCfg",
    "Se3Keyboard",
    "Se3KeyboardCfg",
    "Se3SpaceMouse",
    "Se3SpaceMouseCfg",
    "create_teleop_device",
]
