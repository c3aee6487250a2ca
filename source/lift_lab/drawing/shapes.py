"""Shapes that are drawn over a scene: a marker is a few primitives, placed many times."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np

_GEOM = mujoco.mjtGeom
SPHERE = int(_GEOM.mjGEOM_SPHERE)
ELLIPSOID = int(_GEOM.mjGEOM_ELLIPSOID)
BOX = int(_GEOM.mjGEOM_BOX)
CYLINDER = int(_GEOM.mjGEOM_CYLINDER)
CAPSULE = int(_GEOM.mjGEOM_CAPSULE)
ARROW = int(_GEOM.mjGEOM_ARROW)
TRIANGLE = int(_GEOM.mjGEOM_TRIANGLE)

_CONE_SIDES = 20
_X_FROM_Z = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
_Y_FROM_Z = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
AXES = {"X": _X_FROM_Z, "Y": _Y_FROM_Z, "Z": np.eye(3)}
"""Rotation that brings the z axis to an axis, shape (3, 3)."""


@dataclass
class Primitive:
    """One drawn thing, in the frame of its marker."""

    kind: int
    """One of this module's constants, MuJoCo's ``mjtGeom``."""
    size: np.ndarray
    """Half-lengths along its own axes in m, shape (3,). For an ARROW: the shaft's radius twice, then the length. For a
    TRIANGLE: the lengths of the first two columns of :attr:`mat`, which lead from one corner to the others."""
    position: np.ndarray
    """Its centre in m, shape (3,): of an ARROW its tail, of a TRIANGLE a corner."""
    mat: np.ndarray
    """Its axes as columns, shape (3, 3)."""
    rgba: np.ndarray
    """Colour and opacity in [0, 1], shape (4,)."""

    def row(self) -> np.ndarray:
        """Everything in one array, shape (20,), for :func:`from_row`."""
        return np.concatenate(([self.kind], self.size, self.position, self.mat.ravel(), self.rgba))


def from_row(row: np.ndarray) -> Primitive:
    """The primitive of :meth:`Primitive.row`."""
    return Primitive(int(row[0]), row[1:4], row[4:7], row[7:16].reshape(3, 3), row[16:20])


@dataclass
class Placed:
    """A marker's shape, drawn at several poses."""

    shape: list[Primitive]
    positions: np.ndarray
    """In m, shape (n, 3)."""
    quats: np.ndarray
    """Orientations (w, x, y, z), shape (n, 4)."""
    scales: np.ndarray
    """Along the marker's axes, shape (n, 3)."""

    @property
    def num_geoms(self) -> int:
        """Number of geoms that a scene needs for it."""
        return len(self.shape) * len(self.positions)


def primitive(
    kind: int,
    size: tuple[float, float, float],
    rgba: tuple[float, float, float, float],
    position: tuple[float, float, float] = (0.0, 0.0, 0.0),
    axis: str = "Z",
) -> Primitive:
    """A primitive whose own z axis is along ``axis``."""
    return Primitive(kind, np.asarray(size, float), np.asarray(position, float), AXES[axis], np.asarray(rgba, float))


def frame(scale: tuple[float, float, float]) -> list[Primitive]:
    """Three arrows from the origin: x red, y green, z blue; ``scale`` are their lengths in m."""
    thick = 0.03 * min(scale)
    colours = {"X": (0.9, 0.1, 0.1, 1.0), "Y": (0.1, 0.7, 0.1, 1.0), "Z": (0.1, 0.2, 0.95, 1.0)}
    return [
        primitive(ARROW, (thick, thick, length), rgba, axis=axis)
        for (axis, rgba), length in zip(colours.items(), scale, strict=True)
    ]


def arrow(scale: tuple[float, float, float], rgba: tuple[float, float, float, float]) -> list[Primitive]:
    """An arrow along x from the origin, ``scale[0]`` m long and about ``scale[1]`` m across at its head."""
    return [primitive(ARROW, (0.28 * scale[1], 0.28 * scale[2], scale[0]), rgba, axis="X")]


def cone(radius: float, height: float, axis: str, rgba: tuple[float, float, float, float]) -> list[Primitive]:
    """A cone about the origin, its tip along ``axis``, as MuJoCo's renderer has it: of triangles."""
    angles = np.linspace(0.0, 2 * np.pi, _CONE_SIDES + 1)
    ring = np.stack((radius * np.cos(angles), radius * np.sin(angles), np.full_like(angles, -height / 2)), axis=1)
    ring = ring @ AXES[axis].T
    tip, foot = AXES[axis] @ (0.0, 0.0, height / 2), AXES[axis] @ (0.0, 0.0, -height / 2)
    colour = np.asarray(rgba, float)
    found = []
    for start, end in pairwise(ring):
        found += [triangle((start, end, tip), colour), triangle((end, start, foot), colour)]
    return found


def triangle(corners: tuple[np.ndarray, np.ndarray, np.ndarray], rgba: np.ndarray) -> Primitive:
    """A triangle, seen from the side on which its corners run anticlockwise."""
    first, second, third = corners
    sides = np.stack((second - first, third - first))
    lengths = np.maximum(np.linalg.norm(sides, axis=1), 1e-9)
    along = sides / lengths[:, None]
    normal = np.cross(along[0], along[1])
    normal /= max(float(np.linalg.norm(normal)), 1e-9)
    mat = np.stack((along[0], along[1], normal), axis=1)
    return Primitive(TRIANGLE, np.array([lengths[0], lengths[1], 1.0]), first, mat, rgba)


def add(scene: mujoco.MjvScene, placed: Placed) -> None:
    """Append a marker's instances to a scene, until the scene's geoms are used up."""
    rotation = np.zeros(9)
    for position, quat, scale in zip(placed.positions, placed.quats, placed.scales, strict=True):
        mujoco.mju_quat2Mat(rotation, np.asarray(quat, dtype=np.float64))
        turn = rotation.reshape(3, 3)
        for part in placed.shape:
            if scene.ngeom >= scene.maxgeom:
                return
            size, mat = _scaled(part, scale)
            geom = scene.geoms[scene.ngeom]
            mujoco.mjv_initGeom(
                geom, part.kind, np.zeros(3), position + turn @ (part.position * scale), (turn @ mat).ravel(), part.rgba
            )
            if part.kind == ARROW:
                size = size * (1.0, 1.0, 2.0)  # MuJoCo draws half of what an arrow's size says
            geom.size[:] = size
            scene.ngeom += 1


def _scaled(part: Primitive, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Size and axes of a primitive under a scale of its marker."""
    if np.all(scale == 1.0):
        return part.size, part.mat
    if part.kind == TRIANGLE:
        corner = part.position * scale
        others = [(part.position + part.size[i] * part.mat[:, i]) * scale for i in (0, 1)]
        grown = triangle((corner, others[0], others[1]), part.rgba)
        return grown.size, grown.mat
    # how much each of the primitive's axes grows
    return part.size * np.linalg.norm(part.mat * scale[:, None], axis=0), part.mat
