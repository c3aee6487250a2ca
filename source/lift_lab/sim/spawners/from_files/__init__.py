"""Spawners of USD files and of the ground plane."""

from .from_files import spawn_from_usd, spawn_ground_plane
from .from_files_cfg import FileCfg, GroundPlaneCfg, UsdFileCfg

__all__ = ["FileCfg", "GroundPlaneCfg", "UsdFileCfg", "spawn_from_usd", "spawn_ground_plane"]
