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
    """Isaac Lab's prim path of the visual material. A label here."""
    visual_material: materials.VisualMaterialCfg | None = None
    """Colour and opacity of a :class:`PreviewSurfaceCfg`; None keeps the default grey."""
    physics_material_path: str = "material"
    """Isaac Lab's prim path of the physics material. A label here."""
    physics_material: materials.PhysicsMaterialCfg | None = None
    """A :class:`DeformableBodyMaterialCfg` for a deformable mesh, a :class:`RigidBodyMaterialCfg` for a rigid one."""


@configclass
class MeshCuboidCfg(MeshCfg):
    """A box of full lengths :attr:`size`."""

    func: Callable = spawn_mesh_cuboid
    size: tuple[float, float, float] = MISSING
    """Full lengths along x, y and z in m."""

    _ranges: ClassVar[Ranges] = {"size": POSITIVE}
