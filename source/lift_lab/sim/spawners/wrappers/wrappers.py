"""Isaac Lab's spawners of different assets in different environments: all environments share one model here."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn

from lift_lab.utils.errors import ConfigError

if TYPE_CHECKING:
    from .wrappers_cfg import MultiAssetSpawnerCfg, MultiUsdFileCfg


def spawn_multi_asset(prim_path: str, cfg: MultiAssetSpawnerCfg) -> NoReturn:
    """Refuse.

    Raises:
        ConfigError: always.
    """
    raise ConfigError(f"'{prim_path}': all environments share one model; spawn one of the assets_cfg instead")


def spawn_multi_usd_file(prim_path: str, cfg: MultiUsdFileCfg) -> NoReturn:
    """Refuse.

    Raises:
        ConfigError: always.
    """
    raise ConfigError(f"'{prim_path}': all environments share one model; name one of the files with UsdFileCfg")
