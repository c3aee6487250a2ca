"""Spawners of USD files and of the ground plane."""

from .from_files import spawn_from_mjcf, spawn_from_urdf, spawn_from_usd, spawn_ground_plane
from .from_files_cfg import FileCfg, GroundPlaneCfg, MjcfFileCfg, UrdfFileCfg, UsdFileCfg

__all__ = [
    "FileCfg",
    "GroundPlaneCfg",
    "MjcfFileCfg",
    "UrdfFileCfg",
    "UsdFileCfg",
    "spawn_from_mjcf",
    "spawn_from_urdf",
    "spawn_from_usd",
    "spawn_ground_plane",
]
