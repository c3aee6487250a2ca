"""Triangles of a compiled model: one coloured mesh for each body, one of its colliders, and the planes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

_DRAWN_GROUPS = (0, 1, 2)
"""Geom groups that MuJoCo's own viewer shows at first; colliders are beyond."""
COLLIDER_COLOUR = (0.95, 0.35, 0.1, 1.0)
"""Colour of colliders, which have none of their own that means anything."""
_NO_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""A geom's colour where none was given: then its material's counts."""
_GEOM = mujoco.mjtGeom


@dataclass
class Mesh:
    """Triangles with a colour at each vertex."""

    vertices: np.ndarray
    """Positions in m, shape (V, 3), float32."""
    faces: np.ndarray
    """Indices of corners, shape (F, 3), int32."""
    colours: np.ndarray
    """sRGB and opacity in [0, 1], shape (V, 4), float32."""

    def to_trimesh(self) -> Any:
        """For a browser: colours become linear, as glTF wants them."""
        import trimesh

        rgb = self.colours[:, :3]
        linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
        rgba = np.concatenate((linear, self.colours[:, 3:]), axis=1)
        return trimesh.Trimesh(
            self.vertices, self.faces, vertex_colors=np.round(rgba * 255).astype(np.uint8), process=False
        )


@dataclass
class BodyMesh:
    """Everything drawn of a body, in its frame."""

    body_id: int
    name: str
    mesh: Mesh
    is_static: bool
    """Whether the body can never move."""


@dataclass
class Plane:
    """A plane that the world has."""

    position: np.ndarray
    """A point of it in m, shape (3,)."""
    quat: np.ndarray
    """Orientation (w, x, y, z) that brings z to its normal, shape (4,)."""
    rgb: np.ndarray
    """Colour in [0, 1], shape (3,)."""


def body_meshes(model: mujoco.MjModel) -> list[BodyMesh]:
    """Return one mesh for each body that has something to draw. Planes of the world are left out."""
    return _meshes(model, lambda geom: _is_drawn(model, geom), _geom_mesh)


def collision_meshes(model: mujoco.MjModel) -> list[BodyMesh]:
    """Return one mesh for each body that can collide. Planes of the world are left out.

    A mesh collides as its convex hull, so the hull is what this returns.
    """
    return _meshes(model, lambda geom: _collides(model, geom), _collider_mesh)


def _meshes(
    model: mujoco.MjModel,
    is_wanted: Callable[[int], bool],
    mesh_of: Callable[[mujoco.MjModel, int], Mesh],
) -> list[BodyMesh]:
    """One mesh for each body that has a geom of some kind."""
    found = []
    for body_id in range(model.nbody):
        first = model.body_geomadr[body_id]
        geoms = range(first, first + model.body_geomnum[body_id]) if first >= 0 else ()
        parts = [mesh_of(model, geom) for geom in geoms if is_wanted(geom) and not _is_ground(model, geom)]
        if parts:
            root = model.body_weldid[body_id]
            is_static = root == 0 and model.body_mocapid[body_id] < 0 and model.body_mocapid[root] < 0
            name = model.body(body_id).name or f"body_{body_id}"
            found.append(BodyMesh(body_id, name, merge(parts), bool(is_static)))
    return found


def planes(model: mujoco.MjModel) -> list[Plane]:
    """The planes fixed to the world."""
    ids = [geom for geom in range(model.ngeom) if _is_ground(model, geom) and _is_drawn(model, geom)]
    return [Plane(model.geom_pos[i].copy(), model.geom_quat[i].copy(), _colour(model, i)[:3]) for i in ids]


def merge(parts: list[Mesh]) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(part.vertices) for part in parts[:-1])])
    return Mesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]).astype(np.int32),
        np.concatenate([part.colours for part in parts]),
    )


def arrow(rgba: tuple[float, float, float, float]) -> Mesh:
    """An arrow of 1 m along x, from the origin, 1 m across at its head."""
    import trimesh

    shaft = trimesh.creation.cylinder(radius=0.2, height=0.7, sections=16)
    shaft.apply_translation((0.0, 0.0, 0.35))
    head = trimesh.creation.cone(radius=0.5, height=0.3, sections=16)
    head.apply_translation((0.0, 0.0, 0.7))
    both: Any = trimesh.util.concatenate([shaft, head])
    x_from_z = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    return _coloured(np.asarray(both.vertices) @ x_from_z.T, np.asarray(both.faces), rgba)


def _is_drawn(model: mujoco.MjModel, geom: int) -> bool:
    return model.geom_group[geom] in _DRAWN_GROUPS and _colour(model, geom)[3] > 0.0


def _collides(model: mujoco.MjModel, geom: int) -> bool:
    return bool(model.geom_contype[geom] or model.geom_conaffinity[geom] or geom in model.pair_geom1) or (
        geom in model.pair_geom2
    )


def _is_ground(model: mujoco.MjModel, geom: int) -> bool:
    return model.geom_type[geom] == _GEOM.mjGEOM_PLANE and model.geom_bodyid[geom] == 0


def _colour(model: mujoco.MjModel, geom: int) -> np.ndarray:
    rgba = model.geom_rgba[geom]
    material = model.geom_matid[geom]
    return model.mat_rgba[material] if material >= 0 and np.allclose(rgba, _NO_COLOUR) else rgba


def _geom_mesh(model: mujoco.MjModel, geom: int) -> Mesh:
    """A geom in its body's frame."""
    vertices, faces = _triangles(model, geom)
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    return _coloured(vertices @ rotation.reshape(3, 3).T + model.geom_pos[geom], faces, _colour(model, geom))


def _collider_mesh(model: mujoco.MjModel, geom: int) -> Mesh:
    """What a geom collides as, in its body's frame, in the colour of colliders."""
    vertices, faces = _convex_hull(model, geom) or _triangles(model, geom)
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    return _coloured(vertices @ rotation.reshape(3, 3).T + model.geom_pos[geom], faces, COLLIDER_COLOUR)


def _convex_hull(model: mujoco.MjModel, geom: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Vertices and faces of the hull that MuJoCo collides a mesh with, in the geom's frame; None of anything else."""
    if model.geom_type[geom] != _GEOM.mjGEOM_MESH:
        return None
    mesh = model.geom_dataid[geom]
    start = model.mesh_graphadr[mesh]
    if start < 0:
        return None
    num_vertices, num_faces = (int(count) for count in model.mesh_graph[start : start + 2])
    # two counts, edge addresses and vertex ids, then edges, then the faces
    start += 2 + 2 * num_vertices + num_vertices + 3 * num_faces
    faces = model.mesh_graph[start : start + 3 * num_faces].reshape(-1, 3)
    used, corners = np.unique(faces, return_inverse=True)
    return model.mesh_vert[model.mesh_vertadr[mesh] + used].copy(), corners.reshape(-1, 3)


def _coloured(vertices: np.ndarray, faces: np.ndarray, rgba: Any) -> Mesh:
    colours = np.tile(np.asarray(rgba, dtype=np.float32), (len(vertices), 1))
    return Mesh(vertices.astype(np.float32), faces.astype(np.int32), colours)


def _triangles(model: mujoco.MjModel, geom: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices in the geom's frame, and faces."""
    import trimesh

    kind, size = model.geom_type[geom], model.geom_size[geom]
    if kind == _GEOM.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        face, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        return model.mesh_vert[first : first + count].copy(), model.mesh_face[face : face + faces].copy()
    if kind == _GEOM.mjGEOM_BOX:
        shape = trimesh.creation.box(extents=2 * size)
        shape.unmerge_vertices()  # sharp edges
    elif kind == _GEOM.mjGEOM_SPHERE:
        shape = trimesh.creation.icosphere(subdivisions=3, radius=size[0])
    elif kind == _GEOM.mjGEOM_ELLIPSOID:
        shape = trimesh.creation.icosphere(subdivisions=3, radius=1.0)
        shape.apply_scale(size)
    elif kind == _GEOM.mjGEOM_CYLINDER:
        shape = trimesh.creation.cylinder(radius=size[0], height=2 * size[1], sections=32)
    elif kind == _GEOM.mjGEOM_CAPSULE:
        shape = trimesh.creation.capsule(radius=size[0], height=2 * size[1])
        shape.apply_translation(-shape.bounds.mean(axis=0))
    elif kind == _GEOM.mjGEOM_PLANE:
        half = [length if length > 0 else 10.0 for length in size[:2]]
        shape = trimesh.creation.box(extents=(2 * half[0], 2 * half[1], 1e-4))
    else:
        shape = trimesh.Trimesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))
    return np.asarray(shape.vertices), np.asarray(shape.faces)
