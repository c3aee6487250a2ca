"""Spawners that choose among assets: configs only."""

from .wrappers import spawn_multi_asset, spawn_multi_usd_file
from .wrappers_cfg import MultiAssetSpawnerCfg, MultiUsdFileCfg

__all__ = ["MultiAssetSpawnerCfg", "MultiUsdFileCfg", "spawn_multi_asset", "spawn_multi_usd_file"]
