"""Author a primitive as a USD stage in memory and send it down the importer's one path."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade

from lift_lab import usd

from ..appearance import apply_appearance
from ..import_notes import log_import
from ..materials import RigidBodyMaterialCfg
from ..materials.notes import note_ignored_material
from ..spawner_cfg import Spawned

if TYPE_CHECKING:
    from .shapes_cfg import CapsuleCfg, ConeCfg, CuboidCfg, CylinderCfg, ShapeCfg, SphereCfg


def _spawn(prim_path: str, cfg: ShapeCfg, gprim: Any, attributes: dict[str, Any]) -> Spawned:
    name = prim_path.rsplit("/", 1)[-1].replace(".*", "")
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    root = UsdGeom.Xform.Define(stage, f"/{name}").GetPrim()
    stage.SetDefaultPrim(root)
    shape = gprim.Define(stage, f"/{name}/geometry")
    for attribute, value in attributes.items():
        shape.GetPrim().GetAttribute(attribute).Set(value)
    if cfg.rigid_props is not None:
        UsdPhysics.RigidBodyAPI.Apply(root)
        mass = UsdPhysics.MassAPI.Apply(root)
        if cfg.mass_props is not None and cfg.mass_props.mass is not None:
            mass.CreateMassAttr(cfg.mass_props.mass)
        elif cfg.mass_props is not None and cfg.mass_props.density is not None:
            mass.CreateDensityAttr(cfg.mass_props.density)
    if cfg.collision_props is not None:
        UsdPhysics.CollisionAPI.Apply(shape.GetPrim())
        if isinstance(cfg.physics_material, RigidBodyMaterialCfg):
            note_ignored_material(prim_path, cfg.physics_material)
            material = UsdShade.Material.Define(stage, f"/{name}/{cfg.physics_material_path.lstrip('/')}")
            physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
            physics.CreateStaticFrictionAttr(cfg.physics_material.static_friction)
            physics.CreateDynamicFrictionAttr(cfg.physics_material.dynamic_friction)
            physics.CreateRestitutionAttr(cfg.physics_material.restitution)
            binding = UsdShade.MaterialBindingAPI.Apply(shape.GetPrim())
            binding.Bind(material, UsdShade.Tokens.weakerThanDescendants, "physics")
    spec, report = usd.load(stage)
    log_import(prim_path, report, ignored=False)
    apply_appearance(spec, cfg)
    return Spawned(spec, report)


def spawn_cuboid(prim_path: str, cfg: CuboidCfg) -> Spawned:
    """Spawn a box of ``cfg.size`` (full lengths in m)."""
    spawned = _spawn(prim_path, cfg, _ScaledCube(cfg.size), {})
    return spawned


class _ScaledCube:
    """A unit UsdGeom.Cube with the box's lengths as its scale."""

    def __init__(self, size: tuple[float, float, float]):
        self._size = size

    def Define(self, stage: Usd.Stage, path: str) -> UsdGeom.Cube:
        cube = UsdGeom.Cube.Define(stage, path)
        cube.CreateSizeAttr(1.0)
        UsdGeom.Xformable(cube).AddScaleOp().Set(Gf.Vec3f(*self._size))
        return cube


def spawn_sphere(prim_path: str, cfg: SphereCfg) -> Spawned:
    """Spawn a ball of ``cfg.radius`` (m)."""
    return _spawn(prim_path, cfg, UsdGeom.Sphere, {"radius": cfg.radius})


def _round(cfg: CapsuleCfg | ConeCfg | CylinderCfg) -> dict[str, Any]:
    return {"radius": cfg.radius, "height": cfg.height, "axis": cfg.axis}


def spawn_capsule(prim_path: str, cfg: CapsuleCfg) -> Spawned:
    """Spawn a capsule; ``cfg.height`` is the cylinder's, without the caps (m)."""
    return _spawn(prim_path, cfg, UsdGeom.Capsule, _round(cfg))


def spawn_cylinder(prim_path: str, cfg: CylinderCfg) -> Spawned:
    """Spawn a cylinder (m)."""
    return _spawn(prim_path, cfg, UsdGeom.Cylinder, _round(cfg))


def spawn_cone(prim_path: str, cfg: ConeCfg) -> Spawned:
    """Spawn a cone (m)."""
    return _spawn(prim_path, cfg, UsdGeom.Cone, _round(cfg))
