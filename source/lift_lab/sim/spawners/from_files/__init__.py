"""Spawners of USD files and of the ground plane."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from .from_files import spawn_from_usd, spawn_ground_plane
from .from_files_cfg import FileCfg, GroundPlaneCfg, UsdFileCfg

if TYPE_CHECKING:
    from ....isaac.spawners import MjcfFileCfg, UrdfFileCfg, spawn_from_mjcf, spawn_from_urdf
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
