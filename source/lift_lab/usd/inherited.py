"""Schemas that prims have without naming them: from a prim above, or built into a vendor's schema.

CollisionAPI on a prim that is no shape makes every shape below it a collider, as in PhysX. usd-core's parser only finds
shapes that carry CollisionAPI themselves. So the schema and its attributes are copied to the shapes below before, on
the session layer. USD itself inherits bound materials.

Newton's and MuJoCo's schemas have those of UsdPhysics built in. USD knows this only where these schemas are registered.
So a file may name `MjcCollisionAPI` alone and mean a collider.
"""

from __future__ import annotations

import fnmatch
import re
from dataclasses import dataclass

from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from lift_lab.usd import dialects
from lift_lab.usd.parse import applied_schemas, has_schema
from lift_lab.usd.report import ImportReport
from lift_lab.usd.shapes import KINDS
from lift_lab.usd.stage import is_below

_EVERYTHING = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
_PASSED = (
    *("physics:collisionEnabled", "physics:approximation", "physxCollision:*Offset", "mjc:shellinertia", "mjc:inertia"),
    *("newton:massModel", "newton:shellThickness"),
    *dialects.patterns(dialects.COLLIDER),
)
"""Attributes of a collider that shapes below take over, where they have none of their own."""
_MERGED = "PhysxMeshMergeCollisionAPI"
_NO_RIGID_SHAPE = re.compile(r"Deformable|Particle|Cloth")


@dataclass(frozen=True)
class Inherited:
    """Prim from which a shape has its CollisionAPI."""

    owner: str
    """Path of the prim above that carries the schema."""
    attributes: frozenset[str]
    """Attributes that were copied from it."""


_BUILT_IN: dict[str, tuple[str, ...]] = {
    "NewtonArticulationRootAPI": ("PhysicsArticulationRootAPI",),
    "NewtonMassAPI": ("PhysicsMassAPI",),
    "NewtonCollisionAPI": ("PhysicsCollisionAPI",),
    "NewtonSDFCollisionAPI": ("PhysicsCollisionAPI",),
    "NewtonMeshCollisionAPI": ("PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"),
    "NewtonMaterialAPI": ("PhysicsMaterialAPI",),
    "MjcCollisionAPI": ("PhysicsCollisionAPI",),
    "MjcMeshCollisionAPI": ("PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"),
    "MjcMaterialAPI": ("PhysicsMaterialAPI",),
}
"""Schemas of UsdPhysics in those of newton-usd-schemas 0.6.0 and mujoco-usd-converter 0.8.0, also by way of another."""


def add_built_in_schemas(stage: Usd.Stage) -> None:
    """Apply the schemas of UsdPhysics that vendors' schemas have built in.

    Args:
        stage: The stage, its edit target a layer that may be written to.
    """
    while True:
        found = []
        for prim in Usd.PrimRange(stage.GetPseudoRoot(), _EVERYTHING):
            schemas = applied_schemas(prim)
            wanted = {name for schema in schemas for name in _BUILT_IN.get(schema, ()) if name not in schemas}
            if wanted:
                found.append((prim, sorted(wanted)))
        if not _end_instances(stage, [prim for prim, _ in found]):
            break
    for prim, wanted in found:
        for name in wanted:
            prim.AddAppliedSchema(name)


def _end_instances(stage: Usd.Stage, prims: list[Usd.Prim]) -> bool:
    """End the instances that prims are parts of, so that they can be edited; returns whether there were any.

    Prims found before are no longer valid then.
    """
    shared = {_instance(prim) for prim in prims if prim.IsInstanceProxy()}
    with Sdf.ChangeBlock():
        for path in shared:
            Sdf.CreatePrimInLayer(stage.GetEditTarget().GetLayer(), path).instanceable = False
    return bool(shared)


def inherit_colliders(stage: Usd.Stage, report: ImportReport, parts: list[Sdf.Path]) -> dict[str, Inherited]:
    """Make colliders of the shapes below prims with CollisionAPI that are no shapes.

    The nearest such prim above counts; a shape with a CollisionAPI of its own keeps that. Instances are ended where
    their shapes become colliders.

    Args:
        stage: The stage, its edit target a layer that may be written to.
        report: Takes notes of merged meshes.
        parts: Prims that are left alone, with all below (:func:`lift_lab.usd.stage.prototypes`).

    Returns:
        Where each of these shapes has its schema from, by its path.
    """
    while True:
        found = [(shape, owner) for owner in _owners(stage, parts) for shape in _shapes_below(owner)]
        if not _end_instances(stage, [shape for shape, _ in found]):
            break
    inherited = {}
    for owner in {owner for _, owner in found}:
        if has_schema(owner, _MERGED):
            reason = "each mesh collides by itself, not merged into one"
            report.approximate(owner.GetPath(), _MERGED, reason)
            targets = Usd.CollectionAPI(owner, "collisionmeshes").GetIncludesRel().GetTargets()
            if any(not target.HasPrefix(owner.GetPath()) for target in targets):
                reason = "meshes that are not below the prim do not join it"
                report.ignore(owner.GetPath(), "collection:collisionmeshes:includes", reason)
    for shape, owner in found:
        attributes = _pass_on(owner, shape)
        inherited[str(shape.GetPath())] = Inherited(str(owner.GetPath()), attributes)
    return inherited


def _is_shape(prim: Usd.Prim) -> bool:
    return str(prim.GetTypeName()) in KINDS


def _owners(stage: Usd.Stage, parts: list[Sdf.Path]) -> list[Usd.Prim]:
    prims = Usd.PrimRange(stage.GetPseudoRoot(), _EVERYTHING)
    owners = [prim for prim in prims if prim.HasAPI(UsdPhysics.CollisionAPI) and not prim.IsA(UsdGeom.Gprim)]
    return [owner for owner in owners if not is_below(owner.GetPath(), parts)]


def _shapes_below(owner: Usd.Prim) -> list[Usd.Prim]:
    """Shapes without CollisionAPI that belong to `owner` and to no such prim between."""
    merged = Usd.CollectionAPI(owner, "collisionmeshes") if has_schema(owner, _MERGED) else None
    members = merged.ComputeMembershipQuery() if merged and merged.GetIncludesRel().GetTargets() else None
    found = []
    walk = iter(Usd.PrimRange(owner, _EVERYTHING))
    for prim in walk:
        if prim == owner:
            continue
        if prim.HasAPI(UsdPhysics.CollisionAPI):
            walk.PruneChildren()
        elif _is_shape(prim) and _is_rigid(prim) and (members is None or members.IsPathIncluded(prim.GetPath())):
            found.append(prim)
    return found


def _is_rigid(shape: Usd.Prim) -> bool:
    """Whether a shape can be a collider: it is no site, and no body of another kind."""
    schemas = applied_schemas(shape)
    return not any(schema in dialects.SITE_SCHEMAS or _NO_RIGID_SHAPE.search(schema) for schema in schemas)


def _instance(prim: Usd.Prim) -> Sdf.Path:
    """The outermost instance that a prim is a part of."""
    while prim.IsInstanceProxy():
        prim = prim.GetParent()
    return prim.GetPath()


def _pass_on(owner: Usd.Prim, shape: Usd.Prim) -> frozenset[str]:
    UsdPhysics.CollisionAPI.Apply(shape)
    if shape.IsA(UsdGeom.Mesh) and owner.HasAPI(UsdPhysics.MeshCollisionAPI):
        UsdPhysics.MeshCollisionAPI.Apply(shape)
    copied = set()
    for attribute in owner.GetAuthoredAttributes():
        name = attribute.GetName()
        own = shape.GetAttribute(name)
        if (own and own.HasAuthoredValue()) or not any(fnmatch.fnmatchcase(name, pattern) for pattern in _PASSED):
            continue
        value = attribute.Get()
        if value is not None:
            shape.CreateAttribute(name, attribute.GetTypeName(), custom=False).Set(value)
            copied.add(name)
    return frozenset(copied)
