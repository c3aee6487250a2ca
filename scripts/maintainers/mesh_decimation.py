"""Reduce a triangle mesh by quadric edge collapse. Owns the algorithm; knows nothing of files.

Garland and Heckbert, "Surface Simplification Using Quadric Error Metrics", SIGGRAPH 1997: every vertex
carries the sum of squared distances to the planes of the triangles it has swallowed, as a quadratic form; the
edge whose collapse adds least goes next. Open borders get planes of their own, upright on the border, so that
they keep their outline.
"""

from __future__ import annotations

import heapq

import numpy as np

BORDER_WEIGHT = 10.0
"""Weight of a border's plane against a triangle's of the same size."""
FLIP_COSINE = 0.2
"""A collapse that turns a triangle's normal further than this is refused."""

Quadric = tuple[float, ...]
"""a^2, ab, ac, ad, b^2, bc, bd, c^2, cd, d^2 of planes ax + by + cz + d = 0."""


def weld(vertices: np.ndarray, triangles: np.ndarray, tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """Merge vertices (V, 3) that fall into one grid cell of `tolerance` (m); drop triangles (F, 3) that
    vanish."""
    cells, inverse = np.unique(np.round(vertices / tolerance).astype(np.int64), axis=0, return_inverse=True)
    count = np.bincount(inverse.ravel(), minlength=len(cells))
    merged = np.stack([np.bincount(inverse.ravel(), vertices[:, i], len(cells)) / count for i in range(3)], axis=1)
    faces = inverse.ravel()[triangles]
    a, b, c = faces.T
    faces = faces[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    return compact(merged, faces[np.sort(first)])


def compact(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Drop vertices that no triangle uses."""
    used, faces = np.unique(triangles, return_inverse=True)
    return vertices[used], faces.reshape(-1, 3)


def drop_small_parts(vertices: np.ndarray, triangles: np.ndarray, min_extent: float) -> tuple[np.ndarray, np.ndarray]:
    """Drop connected parts whose bounding box's diagonal is shorter than `min_extent` (m): screws and
    lettering."""
    label = np.arange(len(vertices))
    while True:  # every vertex takes the smallest label among its triangles' until none changes
        lowest = label[triangles].min(axis=1)
        new = label.copy()
        for corner in triangles.T:
            np.minimum.at(new, corner, lowest)
        new = new[new]
        if np.array_equal(new, label):
            break
        label = new
    keep = np.zeros(len(vertices), dtype=bool)
    for part in np.unique(label):
        members = label == part
        keep[members] = np.linalg.norm(np.ptp(vertices[members], axis=0)) >= min_extent
    return compact(vertices, triangles[keep[triangles[:, 0]]])


def decimate(vertices: np.ndarray, triangles: np.ndarray, target: int) -> tuple[np.ndarray, np.ndarray]:
    """Collapse edges until at most `target` triangles are left, or none can be collapsed without a fold.

    Args:
        vertices: Shape (V, 3), m.
        triangles: Vertex indices, shape (F, 3), counter-clockwise from outside.
        target: Number of triangles to stop at.

    Returns:
        The reduced vertices and triangles.
    """
    points: list[tuple[float, ...]] = [tuple(p) for p in vertices.tolist()]
    faces: dict[int, tuple[int, int, int]] = dict(enumerate(map(tuple, triangles.tolist())))
    around: list[set[int]] = [set() for _ in points]
    for index, face in faces.items():
        for corner in face:
            around[corner].add(index)
    quadrics = _vertex_quadrics(vertices, triangles)
    stamp = [0] * len(points)
    heap: list[tuple[float, int, int, int, int, tuple[float, ...]]] = []

    def push(u: int, v: int) -> None:
        quadric = tuple(a + b for a, b in zip(quadrics[u], quadrics[v], strict=True))
        cost, point = _best_point(quadric, points[u], points[v])
        heapq.heappush(heap, (cost, u, v, stamp[u], stamp[v], point))

    def folds(moved: int, other: int, point: tuple[float, ...]) -> bool:
        for index in around[moved]:
            face = faces[index]
            if other in face:
                continue
            before = [points[corner] for corner in face]
            after = [point if corner == moved else points[corner] for corner in face]
            n0, n1 = _normal(*before), _normal(*after)
            length = (_dot(n0, n0) * _dot(n1, n1)) ** 0.5
            if _dot(n0, n1) <= FLIP_COSINE * length:
                return True
        return False

    def neighbours(u: int) -> set[int]:
        return {corner for index in around[u] for corner in faces[index]} - {u}

    for u in range(len(points)):
        for v in neighbours(u):
            if u < v:
                push(u, v)
    while len(faces) > target and heap:
        _, u, v, stamp_u, stamp_v, point = heapq.heappop(heap)
        if stamp[u] != stamp_u or stamp[v] != stamp_v:
            continue
        shared = around[u] & around[v]
        # More common neighbours than common triangles: the collapse would pinch the surface.
        if len(neighbours(u) & neighbours(v)) != len(shared) or folds(u, v, point) or folds(v, u, point):
            continue
        points[u] = point
        quadrics[u] = tuple(a + b for a, b in zip(quadrics[u], quadrics[v], strict=True))
        for index in shared:
            for corner in faces.pop(index):
                around[corner].discard(index)
        for index in around[v]:
            a, b, c = faces[index]
            faces[index] = (u if a == v else a, u if b == v else b, u if c == v else c)
            around[u].add(index)
        around[v] = set()
        stamp[v] = -1
        stamp[u] += 1
        for w in neighbours(u):
            push(u, w)
    return compact(np.array(points), np.array(list(faces.values()), dtype=np.int64).reshape(-1, 3))


def _vertex_quadrics(vertices: np.ndarray, triangles: np.ndarray) -> list[Quadric]:
    """The quadric of each vertex: its triangles' planes by area, and the upright planes of open borders."""
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_area = np.linalg.norm(normals, axis=1)
    unit = normals / np.maximum(doubled_area, 1e-30)[:, None]
    total = np.zeros((len(vertices), 10))

    def add(indices: np.ndarray, normal: np.ndarray, point: np.ndarray, weight: np.ndarray) -> None:
        plane = np.concatenate([normal, -np.sum(normal * point, axis=1, keepdims=True)], axis=1)
        rows, columns = np.triu_indices(4)
        np.add.at(total, indices, plane[:, rows] * plane[:, columns] * weight[:, None])

    for corner in range(3):
        add(triangles[:, corner], unit, corners[:, 0], doubled_area / 6)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    owner = np.tile(np.arange(len(triangles)), 3)
    _, inverse, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    border = count[inverse.ravel()] == 1
    start, end, face = edges[border, 0], edges[border, 1], owner[border]
    along = vertices[end] - vertices[start]
    upright = np.cross(along, unit[face])
    upright /= np.maximum(np.linalg.norm(upright, axis=1), 1e-30)[:, None]
    weight = BORDER_WEIGHT * np.sum(along**2, axis=1)
    add(start, upright, vertices[start], weight)
    add(end, upright, vertices[start], weight)
    return [tuple(row) for row in total.tolist()]


def _best_point(q: Quadric, p: tuple[float, ...], r: tuple[float, ...]) -> tuple[float, tuple[float, ...]]:
    """Cost and place of the cheapest point for a collapsed edge: the quadric's minimum, or the best of ends
    and middle."""
    aa, ab, ac, ad, bb, bc, bd, cc, cd, dd = q

    def cost(s: tuple[float, ...]) -> float:
        x, y, z = s
        return x * (aa * x + 2 * (ab * y + ac * z + ad)) + y * (bb * y + 2 * (bc * z + bd)) + z * (cc * z + 2 * cd) + dd

    middle = tuple((a + b) / 2 for a, b in zip(p, r, strict=True))
    candidates = [p, r, middle]
    m0, m1, m2 = bb * cc - bc * bc, ac * bc - ab * cc, ab * bc - ac * bb
    determinant = aa * m0 + ab * m1 + ac * m2
    if determinant > 1e-6 * (aa + bb + cc) ** 3:
        n11, n12, n22 = aa * cc - ac * ac, ab * ac - aa * bc, aa * bb - ab * ab
        best = (
            -(m0 * ad + m1 * bd + m2 * cd) / determinant,
            -(m1 * ad + n11 * bd + n12 * cd) / determinant,
            -(m2 * ad + n12 * bd + n22 * cd) / determinant,
        )
        reach = sum((a - b) ** 2 for a, b in zip(p, r, strict=True))
        if sum((a - b) ** 2 for a, b in zip(best, middle, strict=True)) <= reach:
            candidates.append(best)
    return min(((max(cost(s), 0.0), s) for s in candidates), key=lambda pair: pair[0])


def _normal(a: tuple[float, ...], b: tuple[float, ...], c: tuple[float, ...]) -> tuple[float, float, float]:
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


def _dot(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
