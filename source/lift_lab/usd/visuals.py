"""Visual parts of a stage: visual geoms, sites, cameras and lights."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
from pxr import Usd, UsdGeom, UsdLux

from lift_lab.usd.dialects import SITE_SCHEMAS
from lift_lab.usd.geoms import GROUP_VISUAL, Home, place, renderable
from lift_lab.usd.materials import Appearance, display_group, srgb
from lift_lab.usd.meshes import MeshStore, material_subsets
from lift_lab.usd.names import Names
from lift_lab.usd.parse import ParsedStage, applied_schemas, has_schema
from lift_lab.usd.report import UsdImportError
from lift_lab.usd.shapes import GEOM, Shape, shapes_of
from lift_lab.usd.units import Pose

_FULL_LIGHT = 0.7
"""Diffuse brightness of the brightest light: MuJoCo has no photometric units."""


def add_visuals(
    parsed: ParsedStage,
    names: Names,
    store: MeshStore,
    appearance: Appearance,
    home_of: Callable[[Usd.Prim], Home],
    drawn: set[str],
) -> None:
    """Add everything that renders and is not in `drawn` (colliders that show themselves)."""
    for prim in parsed.prims:
        if is_site(prim):
            _add_site(parsed, names, prim, home_of)
        elif prim.IsA(UsdGeom.Camera):
            _add_camera(parsed, names, prim, home_of)
        elif prim.HasAPI(UsdLux.LightAPI):
            _add_light(parsed, names, prim, home_of)
        elif prim.IsA(UsdGeom.Gprim) and str(prim.GetPath()) not in drawn and renderable(prim):
            try:
                _add_visual(parsed, names, store, appearance, prim, home_of)
            except UsdImportError as error:  # a picture that is broken does not stop the physics
                parsed.report.ignore(error.prim_path, error.attribute, f"not drawn: {error.reason}", tuning=True)


def is_site(prim: Usd.Prim) -> bool:
    """Whether the prim is marked as a site by either dialect."""
    return any(has_schema(prim, name) for name in SITE_SCHEMAS) and "PhysicsCollisionAPI" not in applied_schemas(prim)


def _add_visual(
    parsed: ParsedStage,
    names: Names,
    store: MeshStore,
    appearance: Appearance,
    prim: Usd.Prim,
    home_of: Callable[[Usd.Prim], Home],
) -> None:
    path = str(prim.GetPath())
    if prim.IsA(UsdGeom.Mesh) and not UsdGeom.Mesh(prim).GetPointsAttr().Get():
        return
    home = home_of(prim)
    shapes = [] if prim.IsA(UsdGeom.Points) else shapes_of(parsed, prim, home.frame)
    if not shapes:
        parsed.report.ignore(path, "", f"a {prim.GetTypeName()} is not drawn", tuning=True)
        return
    shape = shapes[0]
    if shape.type == GEOM.mjGEOM_PLANE and home.moving:
        shape = Shape(GEOM.mjGEOM_BOX, (*shape.size[:2], 1e-4), shape.pose)
    for part, subset in _parts(prim, shape):
        owner = str(subset.GetPath()) if subset else path
        geom = home.body.add_geom(name=names.of("geom", owner))
        place(geom, part, store.add(owner, part.mesh, False) if part.mesh else "")
        geom.contype = geom.conaffinity = 0
        geom.density = 0.0
        geom.group = display_group(prim, GROUP_VISUAL)
        appearance.apply(prim, geom, subset)


def _parts(prim: Usd.Prim, shape: Shape) -> list[tuple[Shape, UsdGeom.Subset | None]]:
    """Split a mesh by its material subsets; faces outside all of them stay with the mesh itself."""
    if shape.mesh is None or shape.faces is None:
        return [(shape, None)]
    subsets = material_subsets(prim)
    rest = np.ones(len(shape.faces), dtype=bool)
    parts: list[tuple[Shape, UsdGeom.Subset | None]] = []
    for subset in subsets:
        chosen = np.isin(shape.faces, np.asarray(subset.GetIndicesAttr().Get() or [], dtype=np.int64)) & rest
        rest &= ~chosen
        if chosen.any():
            parts.append((Shape(shape.type, (), shape.pose, shape.mesh.subset(chosen)), subset))
    if rest.all():
        return [(shape, None)]
    if rest.any():
        parts.append((Shape(shape.type, (), shape.pose, shape.mesh.subset(rest)), None))
    return parts


def _add_site(parsed: ParsedStage, names: Names, prim: Usd.Prim, home_of: Callable[[Usd.Prim], Home]) -> None:
    home = home_of(prim)
    site = home.body.add_site(name=names.of("site", str(prim.GetPath())))
    shapes = shapes_of(parsed, prim, home.frame) if prim.IsA(UsdGeom.Gprim) else []
    solid = {GEOM.mjGEOM_SPHERE, GEOM.mjGEOM_CAPSULE, GEOM.mjGEOM_ELLIPSOID, GEOM.mjGEOM_CYLINDER, GEOM.mjGEOM_BOX}
    pose = home.frame.inverse() @ parsed.pose(prim)
    if shapes and shapes[0].type in solid:
        site.type, pose = shapes[0].type, shapes[0].pose
        site.size = [*shapes[0].size, 0.0, 0.0][:3]
    site.pos, site.quat = pose.position, pose.quat
    site.group = display_group(prim, 0)


def _add_camera(parsed: ParsedStage, names: Names, prim: Usd.Prim, home_of: Callable[[Usd.Prim], Home]) -> None:
    home = home_of(prim)
    camera = UsdGeom.Camera(prim).GetCamera(Usd.TimeCode.Default())
    path = str(prim.GetPath())
    pose = home.frame.inverse() @ parsed.pose(prim)
    # Both look along -Z with +Y up.
    element = home.body.add_camera(name=names.of("camera", path), pos=pose.position, quat=pose.quat)
    if camera.projection == type(camera).Orthographic:
        parsed.report.approximate(path, "projection", "an orthographic camera becomes a perspective one", True)
    if camera.focalLength > 0 and camera.verticalAperture > 0:
        element.fovy = math.degrees(2 * math.atan(0.5 * camera.verticalAperture / camera.focalLength))


def _add_light(parsed: ParsedStage, names: Names, prim: Usd.Prim, home_of: Callable[[Usd.Prim], Home]) -> None:
    path = str(prim.GetPath())
    if prim.IsA(UsdLux.DomeLight):
        parsed.report.ignore(path, "", "a dome light has no counterpart; MuJoCo's headlight stays", tuning=True)
        return
    if not renderable(prim):
        return
    home = home_of(prim)
    pose: Pose = home.frame.inverse() @ parsed.pose(prim)
    light = home.body.add_light(name=names.of("light", path), pos=pose.pos, dir=-pose.rot[:, 2])
    api = UsdLux.LightAPI(prim)
    color = np.asarray(srgb(api.GetColorAttr().Get() or (1, 1, 1)))
    light.diffuse = _FULL_LIGHT * color
    distant = prim.IsA(UsdLux.DistantLight)
    kinds = mujoco.mjtLightType
    light.type = kinds.mjLIGHT_DIRECTIONAL if distant else kinds.mjLIGHT_POINT
    parsed.report.approximate(path, "inputs:intensity", "intensity and size of a light are not carried over", True)
