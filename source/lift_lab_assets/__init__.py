"""Robot configurations and the USD files they spawn.

Import a configuration as Isaac Lab users do: ``from lift_lab_assets import FRANKA_PANDA_CFG``.
"""

from lift_lab.utils.assets import ASSETS_USD_DIR

LIFT_LAB_ASSETS_USD_DIR = str(ASSETS_USD_DIR)
"""Folder of the USD files that ship: `franka_panda.usda`, `cube.usda`, `table.usda`, `cartpole.usda`,
`cabinet.usda`."""

from .robots import *  # noqa: E402
