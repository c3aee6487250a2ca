"""Triangle meshes: reading UsdGeom.Mesh exactly, fitting simple shapes to them, and storing each mesh once."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import mujoco
import numpy as np
from pxr import Sdf, Usd, UsdGeom

from lift_lab.usd.names import Names
from lift_lab.usd.parse import ParsedStage

_THIN = 1e-3
"""Thickness, as a share of the extent, that a flat collision mesh is given so that it has a hull."""
_FLAT = 1e-4
"""Share of the extent below which a mesh counts as flat: a hull thinner than that is at the mercy of rounding."""
_PROBED = 400
"""Most faces that the convexity test looks at."""


@dataclass
class Triangles:
    """Vertices of shape (n, 3) in metres, triangles (m, 3), texture coordinates (n, 2) or None."""

    vertices: np.ndarray
    triangles: np.ndarray
    texcoords: np.ndarray | None = None

    def transformed(self, linear: np.ndarray) -> Triangles:
        """The mesh under a linear map; a map that mirrors also flips the winding."""
        triangles = self.triangles[:, ::-1] if np.linalg.det(linear) < 0 else self.triangles
        return Triangles(self.vertices @ linear.T, triangles, self.texcoords)

    def subset(self, keep: np.ndarray) -> Triangles:
        """The given triangles with the vertices they use."""
        triangles = self.triangles[keep]
        used, compact = np.unique(triangles, return_inverse=True)
        texcoords = None if self.texcoords is None else self.texcoords[used]
        return Triangles(self.vertices[used], compact.reshape(triangles.shape), texcoords)

    def extent(self) -> float:
        """Largest side of the bounding box."""
        return float(np.ptp(self.vertices, axis=0).max()) if len(self.vertices) else 0.0

    def flat(self) -> bool:
        """Whether the vertices (nearly) lie in one plane, so that there is no hull."""
        if len(self.vertices) < 4:
            return True
        centred = self.vertices - self.vertices.mean(axis=0)
        return bool(np.linalg.svd(centred, compute_uv=False)[-1] <= _FLAT * max(self.extent(), 1e-12))

    def thickened(self) -> Triangles:
        """A flat mesh as a thin slab that reaches below its front face."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a).sum(axis=0)
        norm = np.linalg.norm(normal)
        if norm < 1e-12 * max(self.extent() ** 2, 1e-300):
            normal = np.linalg.svd(self.vertices - self.vertices.mean(axis=0))[2][-1]
            norm = 1.0
        below = self.vertices - normal / norm * max(_THIN * self.extent(), 1e-5)
        count = len(self.vertices)
        return Triangles(
            np.vstack([self.vertices, below]), np.vstack([self.triangles, self.triangles[:, ::-1] + count])
        )

    def concave(self) -> bool:
        """Whether some vertex lies clearly in front of some face (of a sample, if there are many)."""
        step = max(1, len(self.triangles) // _PROBED)
        a, b, c = (self.vertices[self.triangles[::step, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        length = np.linalg.norm(normals, axis=1)
        valid = length > 1e-12
        normals = normals[valid] / length[valid, None]
        corners = self.vertices[:: max(1, len(self.vertices) // 4000)]
        heights = normals @ corners.T - np.einsum("ij,ij->i", normals, a[valid])[:, None]
        tolerance = 2e-3 * self.extent()
        # Either orientation of the winding may be the outer one: a hull face has all vertices on one side.
        return bool(((heights.max(axis=1) > tolerance) & (heights.min(axis=1) < -tolerance)).any())


def read_mesh(parsed: ParsedStage, prim: Usd.Prim) -> tuple[Triangles, np.ndarray]:
    """Points and triangulated faces of a UsdGeom.Mesh, in its own space, in metres.

    Returns:
        The mesh and, for every triangle, the index of the face it came from.

    Raises:
        UsdImportError: Points or topology are missing, inconsistent or not finite.
    """
    mesh = UsdGeom.Mesh(prim)
    points = np.asarray(mesh.GetPointsAttr().Get() or [], dtype=float).reshape(-1, 3)
    counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get() or [], dtype=np.int64)
    indices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get() or [], dtype=np.int64)
    if not len(points) or not len(counts):
        raise parsed.fail(prim, "points", "the mesh has no points or no faces")
    if not np.isfinite(points).all():
        raise parsed.fail(prim, "points", "a point is not finite")
    if (counts < 0).any() or counts.sum() != len(indices):
        raise parsed.fail(prim, "faceVertexCounts", f"sums to {counts.sum()}, but there are {len(indices)} indices")
    if len(indices) and (indices.min() < 0 or indices.max() >= len(points)):
        raise parsed.fail(prim, "faceVertexIndices", f"an index is outside 0..{len(points) - 1}")
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    fans = np.maximum(counts - 2, 0)
    faces = np.repeat(np.arange(len(counts)), fans)
    inner = np.arange(fans.sum()) - np.repeat(np.cumsum(fans) - fans, fans)
    corners = np.stack([starts[faces], starts[faces] + inner + 1, starts[faces] + inner + 2], axis=1)
    holes = mesh.GetHoleIndicesAttr().Get()
    if holes:
        solid = ~np.isin(faces, np.asarray(holes))
        faces, corners = faces[solid], corners[solid]
    texcoords = _texcoords(prim, indices, len(points))
    triangles = indices[corners]
    if texcoords is not None and len(texcoords) == len(indices) and len(texcoords) != len(points):
        points, triangles = points[indices], corners  # one vertex per face corner
    if mesh.GetOrientationAttr().Get() == UsdGeom.Tokens.leftHanded:
        triangles = triangles[:, ::-1]
    distinct = (triangles[:, 0] != triangles[:, 1]) & (triangles[:, 1] != triangles[:, 2])
    distinct &= triangles[:, 0] != triangles[:, 2]
    if not distinct.any():
        raise parsed.fail(prim, "faceVertexIndices", "the mesh has no triangle")
    return Triangles(points * parsed.units.length, triangles[distinct], texcoords), faces[distinct]


def texcoord_primvar(prim: Usd.Prim) -> UsdGeom.Primvar | None:
    """Texture coordinates of a mesh: the primvar `st`, else the first one of a texture coordinate's type."""
    api = UsdGeom.PrimvarsAPI(prim)
    named = api.GetPrimvar("st")
    if named and named.HasAuthoredValue():
        return named
    names = Sdf.ValueTypeNames
    kinds = (names.TexCoord2fArray, names.TexCoord2dArray, names.TexCoord2hArray)
    return next((found for found in api.GetPrimvarsWithAuthoredValues() if found.GetTypeName() in kinds), None)


def _texcoords(prim: Usd.Prim, indices: np.ndarray, points: int) -> np.ndarray | None:
    """Texture coordinates per point or per face corner, None where absent or of another shape."""
    primvar = texcoord_primvar(prim)
    values = primvar.ComputeFlattened() if primvar else None
    if values is None:
        return None
    array = np.asarray(values, dtype=float)
    if array.ndim != 2 or array.shape[1] != 2 or len(array) not in (points, len(indices)):
        return None
    return array


def material_subsets(prim: Usd.Prim) -> list[UsdGeom.Subset]:
    """Face subsets of a mesh that exist to bind materials."""
    return [
        subset
        for subset in UsdGeom.Subset.GetAllGeomSubsets(UsdGeom.Imageable(prim))
        if subset.GetElementTypeAttr().Get() == UsdGeom.Tokens.face
        and subset.GetFamilyNameAttr().Get() == "materialBind"
    ]


class MeshStore:
    """Adds meshes to the spec, each distinct one once, and hands out their names."""

    def __init__(self, spec: mujoco.MjSpec, names: Names) -> None:
        self._spec = spec
        self._names = names
        self._known: dict[str, str] = {}

    def add(self, path: str, mesh: Triangles, collides: bool, hull_vertices: int = -1, shell: bool = False) -> str:
        """Name of the asset for `mesh`, made from the prim at `path` if it is new."""
        if len(mesh.vertices) < 4:
            mesh = _split(mesh)
        vertices = np.ascontiguousarray(mesh.vertices, dtype=np.float64)
        # Positions equal to a tenth of a micrometre are the same asset.
        digest = hashlib.sha1((np.round(vertices, 7) + 0.0).tobytes())
        digest.update(np.ascontiguousarray(mesh.triangles, dtype=np.int64).tobytes())
        digest.update(f"{collides} {hull_vertices} {shell} {mesh.texcoords is not None}".encode())
        if mesh.texcoords is not None:
            digest.update(np.round(mesh.texcoords, 6).tobytes())
        key = digest.hexdigest()
        if key not in self._known:
            name = self._names.of("mesh", path)
            asset = self._spec.add_mesh(name=name)
            asset.uservert = vertices.ravel()
            asset.userface = mesh.triangles.astype(np.int32).ravel()
            if mesh.texcoords is not None:
                flipped = np.column_stack([mesh.texcoords[:, 0], 1.0 - mesh.texcoords[:, 1]])
                asset.usertexcoord = flipped.ravel()
                asset.userfacetexcoord = mesh.triangles.astype(np.int32).ravel()
            inertia = mujoco.mjtMeshInertia
            solid = collides and not shell
            asset.inertia = inertia.mjMESH_INERTIA_CONVEX if solid else inertia.mjMESH_INERTIA_SHELL
            if collides and hull_vertices >= 4:
                asset.maxhullvert = hull_vertices
            self._known[key] = name
        return self._known[key]


def _split(mesh: Triangles) -> Triangles:
    """A single triangle as three around its centroid: MuJoCo wants at least four vertices."""
    a, b, c = mesh.triangles[0]
    corners = mesh.vertices[[a, b, c]]
    triangles = np.array([[0, 1, 3], [1, 2, 3], [2, 0, 3]])
    texcoords = None if mesh.texcoords is None else mesh.texcoords[[a, b, c]]
    if texcoords is not None:
        texcoords = np.vstack([texcoords, texcoords.mean(axis=0)])
    return Triangles(np.vstack([corners, corners.mean(axis=0)]), triangles, texcoords)


def cone(radius: float, height: float, axis: np.ndarray, top: float = 0.0, sides: int = 24) -> Triangles:
    """Cone or frustum about `axis` (rotation from Z), centred, apex or `top` radius towards the positive side."""
    angle = np.arange(sides) * (2 * np.pi / sides)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(sides)])
    low = ring * [radius, radius, 0] - [0, 0, height / 2]
    high = ring * [top, top, 0] + [0, 0, height / 2] if top > 0 else np.array([[0, 0, height / 2]])
    centre = np.array([[0, 0, -height / 2], [0, 0, height / 2]])
    vertices = np.vstack([low, high, centre])
    i, j = np.arange(sides), (np.arange(sides) + 1) % sides
    base = len(low) + len(high)
    faces = [np.column_stack([j, i, np.full(sides, base)])]
    if top > 0:
        faces.append(np.column_stack([i, j, j + sides]))
        faces.append(np.column_stack([i, j + sides, i + sides]))
        faces.append(np.column_stack([i + sides, j + sides, np.full(sides, base + 1)]))
    else:
        faces.append(np.column_stack([i, j, np.full(sides, sides)]))
    return Triangles(vertices @ axis.T, np.vstack(faces))
