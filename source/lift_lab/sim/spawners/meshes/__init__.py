"""Spawners of meshes of simple shapes, rigid or deformable."""

from .meshes import spawn_mesh_cuboid
from .meshes_cfg import MeshCfg, MeshCuboidCfg

__all__ = ["MeshCfg", "MeshCuboidCfg", "spawn_mesh_cuboid"]
