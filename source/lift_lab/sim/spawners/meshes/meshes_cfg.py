"""Configs of meshes of simple shapes (names of Isaac Lab's). Lengths in m."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import POSITIVE, Ranges

from .. import materials
from ..spawner_cfg import DeformableObjectSpawnerCfg, RigidObjectSpawnerCfg
from .meshes import spawn_mesh_cuboid


@configclass
class MeshCfg(RigidObjectSpawnerCfg, DeformableObjectSpawnerCfg):
    """A mesh: deformable with ``deformable_props``, else rigid as a shape of the same name is."""

    visual_material_path: str = "material"
    visual_material: materials.VisualMaterialCfg | None = None
    physics_material_path: str = "material"
    physics_material: materials.PhysicsMaterialCfg | None = None
    """A :class:`DeformableBodyMaterialCfg` for a deformable mesh, a :class:`RigidBodyMaterialCfg` for a rigid one."""


@configclass
class MeshCuboidCfg(MeshCfg):
    """A box of full lengths :attr:`size`."""

    func: Callable = spawn_mesh_cuboid
    size: tuple[float, float, float] = MISSING

    _ranges: ClassVar[Ranges] = {"size": POSITIVE}
