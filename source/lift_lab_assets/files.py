"""Folders of the files that ship: in the installed package, else in the checkout."""

from pathlib import Path

from lift_lab.utils.assets import register_assets

_PACKAGE = Path(__file__).resolve().parent
_PACKAGED = _PACKAGE / "usd"

ASSETS_USD_DIR: Path = _PACKAGED if _PACKAGED.is_dir() else _PACKAGE.parents[1] / "assets" / "usd"
"""USD files: `franka_panda.usda`, `cube.usda`, `table.usda`, `cartpole.usda`, `cabinet.usda` and others."""

PRETRAINED_DIR: Path = ASSETS_USD_DIR.parent / "pretrained"
"""Policies, a folder for each task."""

register_assets(
    ASSETS_USD_DIR,
    {
        "panda_instanceable.usd": "franka_panda.usda",
        "dex_cube_instanceable.usd": "cube.usda",
        "table_instanceable.usd": "table.usda",
        "sektion_cabinet_instanceable.usd": "cabinet.usda",
    },
)
