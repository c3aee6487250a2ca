"""The edge collapse that makes the Panda's visual meshes small."""

import numpy as np
import pytest
from mesh_baking import read_obj
from mesh_decimation import decimate, drop_small_parts, weld


def box(divisions: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit cube's surface, each face a grid of 2 * divisions^2 triangles, its vertices not shared between
    faces."""
    grid = np.linspace(0, 1, divisions + 1)
    u, v = (a.ravel() for a in np.meshgrid(grid, grid, indexing="ij"))
    i, j = (a.ravel() for a in np.meshgrid(np.arange(divisions), np.arange(divisions), indexing="ij"))
    corner = i * (divisions + 1) + j
    quad = np.stack([corner, corner + divisions + 1, corner + divisions + 2, corner + 1], axis=1)
    face = np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])
    vertices, triangles = [], []
    for axis in range(3):
        for side in (0, 1):
            points = np.zeros((len(u), 3))
            points[:, axis], points[:, (axis + 1) % 3], points[:, (axis + 2) % 3] = side, u, v
            triangles.append((face if side else face[:, ::-1]) + len(u) * len(vertices))
            vertices.append(points)
    return np.concatenate(vertices), np.concatenate(triangles)


def sphere(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """A unit sphere: a cube's surface pushed out."""
    vertices, triangles = weld(*box(rings), 1e-6)
    centred = vertices - 0.5
    return centred / np.linalg.norm(centred, axis=1, keepdims=True), triangles


def volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Signed volume of a closed surface (divergence theorem); positive where triangles look outwards."""
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_weld_joins_the_faces_of_a_box_along_its_edges():
    vertices, triangles = weld(*box(4), 1e-6)
    assert len(triangles) == 6 * 2 * 16
    assert len(vertices) - len(triangles) // 2 == 2  # Euler's formula of a closed surface: V - F / 2 = 2


def test_a_finely_divided_box_comes_down_to_its_twelve_triangles_exactly():
    vertices, triangles = decimate(*weld(*box(6), 1e-6), 12)
    assert len(triangles) == 12
    assert volume(vertices, triangles) == pytest.approx(1.0, abs=1e-9)


def test_a_reduced_sphere_stays_closed_and_close_to_the_sphere():
    fine, coarse = sphere(14), decimate(*sphere(14), 300)
    edges = np.sort(np.concatenate([coarse[1][:, [0, 1]], coarse[1][:, [1, 2]], coarse[1][:, [2, 0]]]), axis=1)
    _, uses = np.unique(edges, axis=0, return_counts=True)
    assert len(fine[1]) == 2352
    assert 290 <= len(coarse[1]) <= 300
    assert (uses == 2).all()
    np.testing.assert_allclose(np.linalg.norm(coarse[0], axis=1), 1.0, atol=0.02)
    assert volume(*coarse) == pytest.approx(4 / 3 * np.pi, rel=0.03)


def test_an_open_sheet_keeps_its_outline():
    vertices, triangles = box(8)
    sheet = vertices[triangles[:128].ravel()], np.arange(384).reshape(-1, 3)
    reduced, faces = decimate(*weld(*sheet, 1e-6), 4)
    a, b, c = reduced[faces].transpose(1, 0, 2)
    assert len(faces) <= 4
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(1.0, abs=1e-6)


def test_small_parts_are_dropped_and_large_ones_kept():
    vertices, triangles = weld(*box(2), 1e-6)
    both = (
        np.concatenate([vertices, vertices * 0.001 + 3]),
        np.concatenate([triangles, triangles + len(vertices)]),
    )
    kept, faces = drop_small_parts(*both, min_extent=0.01)
    np.testing.assert_allclose(kept, vertices)
    assert np.array_equal(faces, triangles)


def test_obj_polygons_become_triangles_grouped_by_material(tmp_path):
    path = tmp_path / "quad.obj"
    path.write_text(
        "# comment\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\n\n"
        "usemtl white\nf 1//1 2//1 3//1 4//1\nusemtl grey\nf 1/1/1 2/2/1 4/4/1\n"
    )
    vertices, triangles = read_obj(path)
    assert vertices.shape == (4, 3)
    assert triangles["white"].tolist() == [[0, 1, 2], [0, 2, 3]]
    assert triangles["grey"].tolist() == [[0, 1, 3]]
