"""Colliders: one MuJoCo geom (or several) per prim with PhysicsCollisionAPI."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from pxr import Usd, UsdGeom

from lift_lab.usd import dialects
from lift_lab.usd.materials import Appearance, Contact, ContactMaterials, display_group
from lift_lab.usd.meshes import MeshStore, material_subsets
from lift_lab.usd.names import Names
from lift_lab.usd.parse import ParsedStage, has_schema, value_of
from lift_lab.usd.shapes import GEOM, Shape, bounding_box, bounding_sphere, shapes_of
from lift_lab.usd.units import Pose

GROUP_VISIBLE, GROUP_VISUAL, GROUP_HIDDEN = 0, 2, 3
_HULL_NOTES = {
    "none": "triangle mesh",
    "meshSimplification": "simplified triangle mesh",
    "sdf": "signed distance field",
    "convexDecomposition": "convex decomposition",
    "sphereFill": "filling of spheres",
}
_APPROXIMATIONS = (*_HULL_NOTES, "convexHull", "boundingCube", "boundingSphere")


@dataclass
class Home:
    """Owner of a prim's geoms: a MuJoCo body, its frame in the world and its prim path (None: static)."""

    body: mujoco.MjsBody
    frame: Pose
    path: str | None
    moving: bool


@dataclass
class Collider:
    """A built collider, with what mass and contact filters need of it."""

    path: str
    prim: Usd.Prim
    home: Home
    shapes: list[Shape]
    contact: Contact
    desc: Any
    shell: bool
    shows_itself: bool = True
    """False if a visual geom draws the prim, because the geom that collides has another shape or only one colour."""
    geoms: list[mujoco.MjsGeom] = field(default_factory=list)


def renderable(prim: Usd.Prim) -> bool:
    """Whether a renderer would draw the prim: visible, and of purpose default or render."""
    imageable = UsdGeom.Imageable(prim)
    if not imageable or imageable.ComputePurpose() not in (UsdGeom.Tokens.default_, UsdGeom.Tokens.render):
        return False
    return imageable.ComputeVisibility() != UsdGeom.Tokens.invisible


def place(geom: mujoco.MjsGeom, shape: Shape, mesh_name: str = "") -> None:
    """Write type, size and pose of a shape to a geom."""
    geom.type = shape.type
    geom.pos, geom.quat = shape.pose.position, shape.pose.quat
    if shape.type == GEOM.mjGEOM_MESH:
        geom.meshname = mesh_name
    else:
        geom.size = [*shape.size, 0.0, 0.0][:3]


def add_colliders(
    parsed: ParsedStage,
    names: Names,
    store: MeshStore,
    contacts: ContactMaterials,
    appearance: Appearance,
    home_of: Callable[[Usd.Prim], Home],
) -> list[Collider]:
    """Add a geom for every enabled collider and return them in stage order."""
    colliders = []
    for path, desc in parsed.shapes.items():
        prim = parsed.prim(path)
        if not desc.collisionEnabled:
            continue
        home = home_of(prim)
        drawn = shapes_of(parsed, prim, home.frame)
        shapes = _collision_shapes(parsed, prim, desc, drawn, home)
        if not shapes:
            parsed.report.ignore(path, "PhysicsCollisionAPI", f"no collision geometry for a {prim.GetTypeName()}")
            continue
        shell = bool(value_of(prim, "mjc:shellinertia")) or value_of(prim, "newton:massModel") == "shell"
        shell = shell or value_of(prim, "mjc:inertia") == "shell"
        collider = Collider(path, prim, home, shapes, contacts.of_shape(prim, desc), desc, shell)
        replaced = shapes[0] is not drawn[0] or (prim.IsA(UsdGeom.Mesh) and bool(material_subsets(prim)))
        collider.shows_itself = not replaced
        shown = renderable(prim) and not replaced
        for i, shape in enumerate(shapes):
            geom = home.body.add_geom(name=names.of("geom", path, f"_{i}" if i else ""))
            place(geom, shape, _mesh_name(parsed, store, prim, shape, shell))
            geom.group = display_group(prim, GROUP_VISIBLE if shown else GROUP_HIDDEN)
            contacts.apply(collider.contact, geom)
            _contact_fields(parsed, prim, geom)
            appearance.apply(prim, geom)
            collider.geoms.append(geom)
        colliders.append(collider)
    for prim in parsed.prims:
        path = str(prim.GetPath())
        if has_schema(prim, "PhysicsCollisionAPI") and path not in parsed.shapes:
            if prim.IsA(UsdGeom.Gprim):
                parsed.report.ignore(path, "PhysicsCollisionAPI", f"usd-core has no shape of a {prim.GetTypeName()}")
            elif not any(shape.startswith(f"{path}/") for shape in parsed.shapes):
                parsed.report.ignore(path, "PhysicsCollisionAPI", "there is no collision shape below the prim")
    return colliders


def _mesh_name(parsed: ParsedStage, store: MeshStore, prim: Usd.Prim, shape: Shape, shell: bool) -> str:
    if shape.mesh is None:
        return ""
    limit = dialects.resolve(parsed, dialects.COLLIDER, "hull vertices", prim)
    return store.add(str(prim.GetPath()), shape.mesh, True, int(limit or -1), shell)


def _collision_shapes(parsed: ParsedStage, prim: Usd.Prim, desc: Any, shapes: list[Shape], home: Home) -> list[Shape]:
    path = str(prim.GetPath())
    found = []
    for shape in shapes:
        if shape.note:
            parsed.report.approximate(path, "", shape.note)
        if shape.type == GEOM.mjGEOM_PLANE and home.moving:
            parsed.report.approximate(path, "", "a plane on a moving body becomes a thin box")
            width, length, _ = shape.size
            shape = Shape(
                GEOM.mjGEOM_BOX, (width, length, 0.005), shape.pose @ Pose(np.array([0, 0, -0.005]), np.eye(3))
            )
        elif shape.mesh is not None and prim.IsA(UsdGeom.Mesh):
            authored = str(value_of(prim, "physics:approximation") or "none")
            if authored not in _APPROXIMATIONS:
                reason = f"'{authored}' is none of {', '.join(_APPROXIMATIONS)}: the mesh collides as its convex hull"
                parsed.report.ignore(path, "physics:approximation", reason)
            shape = _mesh_shape(parsed, path, str(desc.approximation), shape)
        found.append(shape)
    return found


def _mesh_shape(parsed: ParsedStage, path: str, approximation: str, shape: Shape) -> Shape:
    assert shape.mesh is not None
    if approximation == "boundingCube":
        return bounding_box(shape)
    if approximation == "boundingSphere":
        return bounding_sphere(shape)
    if shape.mesh.flat():
        parsed.report.approximate(path, "points", "a flat mesh collides as a thin slab below its face")
        return Shape(shape.type, shape.size, shape.pose, shape.mesh.thickened())
    if approximation in _HULL_NOTES and shape.mesh.concave():
        reason = f"a concave {_HULL_NOTES[approximation]} collides as its convex hull"
        parsed.report.approximate(path, "physics:approximation", reason)
    return shape


def _contact_fields(parsed: ParsedStage, prim: Usd.Prim, geom: mujoco.MjsGeom) -> None:
    def read(quantity: str) -> Any:
        return dialects.resolve(parsed, dialects.COLLIDER, quantity, prim)

    for quantity in ("margin", "gap", "solmix"):
        value = read(quantity)
        if value is not None:
            setattr(geom, quantity, float(value))
    for quantity in ("condim", "priority", "contype", "conaffinity"):
        value = read(quantity)
        if quantity == "condim" and value is not None and value not in (1, 3, 4, 6):
            raise parsed.fail(prim, "mjc:condim", f"must be 1, 3, 4 or 6, is {value:g}")
        if value is not None:
            setattr(geom, quantity, int(value))
    for quantity in ("solref", "solimp", "friction"):
        value = read(quantity)
        if value is not None:
            merged = np.array(getattr(geom, quantity), dtype=float)
            given = np.atleast_1d(value)[: len(merged)]
            merged[: len(given)] = given
            setattr(geom, quantity, merged)
    offset = value_of(prim, "physxCollision:contactOffset")
    if offset is not None and np.isfinite(offset) and read("gap") is None:
        rest = value_of(prim, "physxCollision:restOffset")
        rest = rest if rest is not None and np.isfinite(rest) else 0.0
        geom.gap = float(offset - rest) * parsed.units.length
        parsed.report.took("gap", "physx")
