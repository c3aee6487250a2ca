"""Author a mesh as a USD stage in memory and send it down the importer's one path."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

from lift_lab import usd
from lift_lab.usd.deformable import BODY_SCHEMA, MATERIAL_SCHEMA
from lift_lab.utils.errors import ConfigError

from ..import_notes import log_import
from ..materials import DeformableBodyMaterialCfg
from ..shapes import spawn_cuboid
from ..spawner_cfg import Spawned

if TYPE_CHECKING:
    from .meshes_cfg import MeshCuboidCfg

_CORNERS = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
"""Faces of the unit cube, counter-clockwise seen from outside."""


def spawn_mesh_cuboid(prim_path: str, cfg: MeshCuboidCfg) -> Spawned:
    """Spawn a box of ``cfg.size`` (full lengths in m), deformable if it has ``deformable_props``.

    Raises:
        ConfigError: rigid and deformable properties at once, or a material of the other kind.
    """
    if cfg.deformable_props is None:
        if isinstance(cfg.physics_material, DeformableBodyMaterialCfg):
            raise ConfigError(f"'{prim_path}': a DeformableBodyMaterialCfg needs deformable_props")
        return spawn_cuboid(prim_path, cfg)  # type: ignore[arg-type]  # it has all that a CuboidCfg has
    for name in ("rigid_props", "collision_props"):
        if getattr(cfg, name) is not None:
            raise ConfigError(f"'{prim_path}': spawn.{name} and spawn.deformable_props exclude each other")
    material = cfg.physics_material
    if material is not None and not isinstance(material, DeformableBodyMaterialCfg):
        kind = type(material).__name__
        raise ConfigError(f"'{prim_path}': a deformable mesh takes a DeformableBodyMaterialCfg, not a {kind}")
    name = prim_path.rsplit("/", 1)[-1].replace(".*", "")
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, f"/{name}").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, f"/{name}/geometry/mesh")
    mesh.CreatePointsAttr([Gf.Vec3f(*(c * s for c, s in zip(corner, cfg.size, strict=True))) for corner in _CORNERS])
    mesh.CreateFaceVertexCountsAttr([4] * len(_FACES))
    mesh.CreateFaceVertexIndicesAttr([corner for face in _FACES for corner in face])
    prim = mesh.GetPrim()
    prim.AddAppliedSchema(BODY_SCHEMA)
    mass = cfg.mass_props.mass if cfg.mass_props is not None else None
    if mass is not None:
        UsdPhysics.MassAPI.Apply(prim).CreateMassAttr(mass)
    if material is not None:
        _bind(stage, prim, f"/{name}/{cfg.physics_material_path.lstrip('/')}", material)
    spec, report = usd.load(stage)
    log_import(prim_path, report)
    return Spawned(spec, report)


def _bind(stage: Usd.Stage, prim: Usd.Prim, path: str, cfg: DeformableBodyMaterialCfg) -> None:
    """Author a deformable material and bind it."""
    material = UsdShade.Material.Define(stage, path)
    material.GetPrim().AddAppliedSchema(MATERIAL_SCHEMA)
    for attribute, value in (
        ("youngsModulus", cfg.youngs_modulus),
        ("poissonsRatio", cfg.poissons_ratio),
        ("elasticityDamping", cfg.elasticity_damping),
        ("dynamicFriction", cfg.dynamic_friction),
        ("density", cfg.density),
    ):
        if value is not None:
            name = f"physxDeformableBodyMaterial:{attribute}"
            material.GetPrim().CreateAttribute(name, Sdf.ValueTypeNames.Float, custom=False).Set(value)
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
