"""Robot configurations, and the USD files and policies that ship.

Import a configuration as Isaac Lab users do: ``from lift_lab_assets import FRANKA_PANDA_CFG``. Robots are loaded when
one is asked for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import robots
from .files import ASSETS_USD_DIR as ASSETS_USD_DIR
from .files import PRETRAINED_DIR as PRETRAINED_DIR

if TYPE_CHECKING:
    from .robots import *

LIFT_LAB_ASSETS_USD_DIR = str(ASSETS_USD_DIR)
"""Folder of the USD files, named as in Isaac Lab."""


if not TYPE_CHECKING:  # a type checker would take every name for a robot

    def __getattr__(name: str) -> Any:
        """A robot's configuration, from any module of :mod:`lift_lab_assets.robots`.

        Raises:
            AttributeError: no module has it; names the nearest.
        """
        if name == "__all__":  # a star import asks for it
            own = [name for name in globals() if name.isupper() and name != "TYPE_CHECKING"]
            return [*own, *robots.robot_configs()]
        return getattr(robots, name)


def __dir__() -> list[str]:
    return sorted({*globals(), *dir(robots)})
