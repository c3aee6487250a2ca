"""Keyboards: configs only."""

from .se2_keyboard import Se2Keyboard, Se2KeyboardCfg
from .se3_keyboard import Se3Keyboard, Se3KeyboardCfg

__all__ = [
    "Se2Keyboard",
    "Se2KeyboardCfg",
    "Se3Keyboard",
    "Se3KeyboardCfg",
]
