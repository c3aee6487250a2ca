"""Gamepads: configs only."""

from .se2_gamepad import Se2Gamepad, Se2GamepadCfg
from .se3_gamepad import Se3Gamepad, Se3GamepadCfg

__all__ = [
    "Se2Gamepad",
    "Se2GamepadCfg",
    "Se3Gamepad",
    "Se3GamepadCfg",
]
