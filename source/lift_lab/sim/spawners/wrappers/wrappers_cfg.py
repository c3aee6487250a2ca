"""Configs of spawners that choose among assets (data only; names of Isaac Lab's)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING

from lift_lab.utils import configclass

from ..from_files import UsdFileCfg
from ..spawner_cfg import DeformableObjectSpawnerCfg, RigidObjectSpawnerCfg, SpawnerCfg
from .wrappers import spawn_multi_asset, spawn_multi_usd_file


@configclass
class MultiAssetSpawnerCfg(RigidObjectSpawnerCfg, DeformableObjectSpawnerCfg):
    """One of some assets for each environment: spawning one raises."""

    func: Callable = spawn_multi_asset
    assets_cfg: list[SpawnerCfg] = MISSING
    random_choice: bool = True


@configclass
class MultiUsdFileCfg(UsdFileCfg):
    """One of some USD files for each environment: spawning one raises."""

    func: Callable = spawn_multi_usd_file
    usd_path: str | list[str] = MISSING
    random_choice: bool = True
