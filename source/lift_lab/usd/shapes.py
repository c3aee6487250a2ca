"""UsdGeom primitives as MuJoCo geometry: type, size and pose of a prim inside the frame of its body.

Sizes are computed from the authored attributes and the full transform in double precision. A prim stays a primitive if
it can follow the stretch of its transform (a box along its sides, a sphere along its axes). Any other becomes a mesh,
so shear and other scales are exact too.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from pxr import Usd, UsdGeom

from lift_lab.usd.meshes import Triangles, cone, read_mesh
from lift_lab.usd.parse import ParsedStage
from lift_lab.usd.units import AXES, Pose, axis_rotation, polar

GEOM = mujoco.mjtGeom
_CYCLE = {"X": (1, 2, 0), "Y": (2, 0, 1), "Z": (0, 1, 2)}


@dataclass
class Shape:
    """Geometry of one geom: MuJoCo type and size, pose in the body, triangles if it is a mesh."""

    type: mujoco.mjtGeom
    size: tuple[float, ...]
    pose: Pose
    mesh: Triangles | None = None
    faces: np.ndarray | None = None
    """For a mesh: source face of every triangle."""
    note: str = ""
    """Description of what the shape has only approximately, empty if nothing."""


def local_affine(parsed: ParsedStage, prim: Usd.Prim, frame: Pose) -> tuple[np.ndarray, np.ndarray]:
    """Transform from the prim's space to the rigid `frame`: linear part, origin in metres."""
    linear, origin = parsed.affine(prim)
    return frame.rot.T @ linear, frame.rot.T @ (origin - frame.pos)


def shapes_of(parsed: ParsedStage, prim: Usd.Prim, frame: Pose) -> list[Shape]:
    """Geometry of a Gprim in `frame`; empty for a type without one here.

    Raises:
        UsdImportError: A size is not a positive number or a mesh is inconsistent.
    """
    linear, origin = local_affine(parsed, prim, frame)
    rot, stretch = polar(linear)
    if abs(np.linalg.det(stretch)) < 1e-24:
        raise parsed.fail(prim, "xformOp:scale", "the prim is scaled to nothing")
    pose = Pose(origin, rot)
    reader = _READERS.get(str(prim.GetTypeName()))
    if reader is None:
        return []
    return reader(parsed, prim, pose, stretch)


def _number(parsed: ParsedStage, prim: Usd.Prim, name: str) -> float:
    value = prim.GetAttribute(name).Get()
    if value is None or not np.isfinite(value) or value <= 0:
        raise parsed.fail(prim, name, f"must be a positive number, is {value}")
    return float(value) * parsed.units.length


def _axis(parsed: ParsedStage, prim: Usd.Prim) -> str:
    axis = str(prim.GetAttribute("axis").Get() or "Z")
    if axis not in AXES:
        raise parsed.fail(prim, "axis", f"must be X, Y or Z, is '{axis}'")
    return axis


def _diagonal(stretch: np.ndarray) -> np.ndarray | None:
    """Absolute scale along the prim's own axes, None if the stretch is not along them."""
    diagonal = np.diag(stretch)
    off = np.abs(stretch - np.diag(diagonal)).max()
    return np.abs(diagonal) if off < 1e-6 * np.abs(diagonal).max() else None


def _cube(parsed: ParsedStage, prim: Usd.Prim, pose: Pose, stretch: np.ndarray) -> list[Shape]:
    half = 0.5 * _number(parsed, prim, "size")
    scale = _diagonal(stretch)
    if scale is not None:
        return [Shape(GEOM.mjGEOM_BOX, tuple(half * scale), pose)]
    return [_as_mesh(_box_mesh(half), pose, stretch)]


def _sphere(parsed: ParsedStage, prim: Usd.Prim, pose: Pose, stretch: np.ndarray) -> list[Shape]:
    radius = _number(parsed, prim, "radius")
    # The principal axes of the stretch are those of the ellipsoid, whatever the prim's own axes are.
    scale = _diagonal(stretch)
    if scale is None:
        values, vectors = np.linalg.eigh(stretch)
        vectors = vectors * np.sign(np.linalg.det(vectors))
        pose, scale = Pose(pose.pos, pose.rot @ vectors), np.abs(values)
    if np.ptp(scale) < 1e-6 * scale.max():
        return [Shape(GEOM.mjGEOM_SPHERE, (radius * float(scale.mean()),), pose)]
    return [Shape(GEOM.mjGEOM_ELLIPSOID, tuple(radius * scale), pose)]


def _round(kind: mujoco.mjtGeom):
    def read(parsed: ParsedStage, prim: Usd.Prim, pose: Pose, stretch: np.ndarray) -> list[Shape]:
        radius, height = _number(parsed, prim, "radius"), float(prim.GetAttribute("height").Get() or 0.0)
        height *= parsed.units.length
        if not np.isfinite(height) or height < 0 or (height == 0 and kind == GEOM.mjGEOM_CYLINDER):
            raise parsed.fail(prim, "height", f"must be a positive number, is {height}")
        return [_round_shape(kind, radius, height, _axis(parsed, prim), pose, stretch)]

    return read


def _round_shape(
    kind: mujoco.mjtGeom, radius: float, height: float, axis: str, pose: Pose, stretch: np.ndarray
) -> Shape:
    scale = _diagonal(stretch)
    turned = Pose(pose.pos, pose.rot @ axis_rotation(axis))
    if scale is None:
        return _as_mesh(_round_mesh(kind, radius, height, axis), pose, stretch)
    side_a, side_b, along = (float(scale[i]) for i in _CYCLE[axis])
    if abs(side_a - side_b) > 1e-6 * max(side_a, side_b):
        return _as_mesh(_round_mesh(kind, radius, height, axis), pose, stretch)
    note = ""
    if kind == GEOM.mjGEOM_CAPSULE and abs(along - side_a) > 1e-6 * max(along, side_a):
        note = "non-uniform scale: the caps stay half spheres of the scaled radius"
    if kind == GEOM.mjGEOM_CAPSULE and height == 0:
        return Shape(GEOM.mjGEOM_SPHERE, (radius * side_a,), turned, note=note)
    return Shape(kind, (radius * side_a, 0.5 * height * along), turned, note=note)


def _tapered(kind: mujoco.mjtGeom):
    def read(parsed: ParsedStage, prim: Usd.Prim, pose: Pose, stretch: np.ndarray) -> list[Shape]:
        bottom, top = (_number(parsed, prim, f"radius{end}") for end in ("Bottom", "Top"))
        height = _number(parsed, prim, "height")
        if abs(bottom - top) < 1e-9 * bottom:
            return [_round_shape(kind, bottom, height, _axis(parsed, prim), pose, stretch)]
        mesh = cone(bottom, height, axis_rotation(_axis(parsed, prim)), top)
        if kind == GEOM.mjGEOM_CAPSULE:
            ends = [
                _ball_mesh(r, axis_rotation(_axis(parsed, prim)) @ [0, 0, z])
                for r, z in ((bottom, -height / 2), (top, height / 2))
            ]
            mesh = _merge([mesh, *ends])
        return [_as_mesh(mesh, pose, stretch)]

    return read


def _cone(parsed: ParsedStage, prim: Usd.Prim, pose: Pose, stretch: np.ndarray) -> list[Shape]:
    radius, height = _number(parsed, prim, "radius"), _number(parsed, prim, "height")
    shape = _as_mesh(cone(radius, height, axis_rotation(_axis(parsed, prim))), pose, stretch)
    shape.note = "a cone becomes a mesh of 24 sides"
    return [shape]


def _plane(parsed: ParsedStage, prim: Usd.Prim, pose: Pose, stretch: np.ndarray) -> list[Shape]:
    axis = _axis(parsed, prim)
    turned = Pose(pose.pos, pose.rot @ axis_rotation(axis))
    # Turned onto its axis, MuJoCo's local x runs along USD's width and y along its length.
    scale = np.abs(np.diag(stretch))[list({"X": (2, 1), "Y": (0, 2), "Z": (0, 1)}[axis])]
    half = 0.5 * scale * [_number(parsed, prim, "width"), _number(parsed, prim, "length")]
    return [Shape(GEOM.mjGEOM_PLANE, (float(half[0]), float(half[1]), 0.05), turned)]


def _points(parsed: ParsedStage, prim: Usd.Prim, pose: Pose, stretch: np.ndarray) -> list[Shape]:
    points = UsdGeom.Points(prim)
    centres = np.asarray(points.GetPointsAttr().Get() or [], dtype=float).reshape(-1, 3) * parsed.units.length
    widths = np.asarray(points.GetWidthsAttr().Get() or [], dtype=float) * parsed.units.length
    if not len(centres):
        return []
    if len(widths) not in (1, len(centres)) or not np.isfinite(centres).all() or not (widths > 0).all():
        raise parsed.fail(prim, "widths", "needs one positive width, or one per point")
    factor = float(np.abs(np.linalg.eigvalsh(stretch)).max())
    radii = np.broadcast_to(widths, len(centres)) * 0.5 * factor
    placed = centres @ (pose.rot @ stretch).T + pose.pos
    return [Shape(GEOM.mjGEOM_SPHERE, (float(r),), Pose(p, np.eye(3))) for p, r in zip(placed, radii, strict=True)]


def _mesh(parsed: ParsedStage, prim: Usd.Prim, pose: Pose, stretch: np.ndarray) -> list[Shape]:
    triangles, faces = read_mesh(parsed, prim)
    shape = _as_mesh(triangles, pose, stretch)
    shape.faces = faces
    return [shape]


_READERS = {
    "Cube": _cube,
    "Sphere": _sphere,
    "Capsule": _round(GEOM.mjGEOM_CAPSULE),
    "Cylinder": _round(GEOM.mjGEOM_CYLINDER),
    "Capsule_1": _tapered(GEOM.mjGEOM_CAPSULE),
    "Cylinder_1": _tapered(GEOM.mjGEOM_CYLINDER),
    "Cone": _cone,
    "Plane": _plane,
    "Points": _points,
    "Mesh": _mesh,
}
KINDS = frozenset(_READERS)
"""Types of prims that have a shape here."""


def _as_mesh(triangles: Triangles, pose: Pose, stretch: np.ndarray) -> Shape:
    return Shape(GEOM.mjGEOM_MESH, (), pose, triangles.transformed(stretch))


def bounding_box(shape: Shape) -> Shape:
    """Box that bounds a mesh shape, along the axes of its pose."""
    assert shape.mesh is not None
    low, high = shape.mesh.vertices.min(axis=0), shape.mesh.vertices.max(axis=0)
    half = np.maximum(0.5 * (high - low), 1e-5)
    pose = Pose(shape.pose.pos + shape.pose.rot @ (0.5 * (low + high)), shape.pose.rot)
    return Shape(GEOM.mjGEOM_BOX, tuple(half), pose)


def bounding_sphere(shape: Shape) -> Shape:
    """Sphere about the centre of a mesh's bounding box through its farthest vertex."""
    assert shape.mesh is not None
    centre = 0.5 * (shape.mesh.vertices.min(axis=0) + shape.mesh.vertices.max(axis=0))
    radius = float(np.linalg.norm(shape.mesh.vertices - centre, axis=1).max())
    return Shape(GEOM.mjGEOM_SPHERE, (radius,), Pose(shape.pose.pos + shape.pose.rot @ centre, shape.pose.rot))


def _box_mesh(half: float) -> Triangles:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float) * half
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Triangles(corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]))


def _ball_mesh(radius: float, centre: np.ndarray, rings: int = 12, sides: int = 24) -> Triangles:
    polar_angle = np.linspace(0, np.pi, rings + 1)
    around = np.arange(sides) * (2 * np.pi / sides)
    z = np.repeat(np.cos(polar_angle), sides)
    r = np.repeat(np.sin(polar_angle), sides)
    vertices = np.column_stack([r * np.tile(np.cos(around), rings + 1), r * np.tile(np.sin(around), rings + 1), z])
    i, j = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    a, b = (i * sides + j).ravel(), (i * sides + (j + 1) % sides).ravel()
    triangles = np.vstack([np.column_stack([a, a + sides, b]), np.column_stack([b, a + sides, b + sides])])
    return Triangles(vertices * radius + centre, triangles)


def _merge(meshes: list[Triangles]) -> Triangles:
    offsets = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    return Triangles(
        np.vstack([m.vertices for m in meshes]),
        np.vstack([m.triangles + o for m, o in zip(meshes, offsets[:-1], strict=True)]),
    )


def _round_mesh(kind: mujoco.mjtGeom, radius: float, height: float, axis: str) -> Triangles:
    turn = axis_rotation(axis)
    if kind == GEOM.mjGEOM_CYLINDER:
        return cone(radius, height, turn, top=radius)
    ends = [_ball_mesh(radius, turn @ [0, 0, side * height / 2]) for side in (-1, 1)]
    return _merge([cone(radius, max(height, 1e-9), turn, top=radius), *ends])
