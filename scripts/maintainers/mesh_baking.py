"""Bake the Panda's visual meshes: OBJ files in, one small USD file with a reduced mesh a link and colour out.

The source is the folder `dm_robotics/panda/assets/panda` of the PyPI package `dm-robotics-panda` 0.4.8
(Apache-2.0, Copyright 2017 Franka Emika GmbH): link0.obj ... link7.obj, hand.obj and finger.obj, in the
frames of franka_description.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from mesh_decimation import decimate, drop_small_parts, weld
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

SOURCES = {f"panda_link{i}": f"link{i}.obj" for i in range(8)} | {
    "panda_hand": "hand.obj",
    "panda_leftfinger": "finger.obj",
    "panda_rightfinger": "finger.obj",
}

COLORS = {"white": (0.86, 0.86, 0.84), "grey": (0.051, 0.051, 0.051), "metal": (0.45, 0.45, 0.45)}
"""Linear RGB of the painted shells, the dark covers and the bare metal."""

PARTS = {
    "link0.obj": {
        "Part__Feature023_001.001": "grey",
        "Shell001_001.001": "grey",
        "Shell_001.001": "grey",
        "Shell009_001.001": "grey",
        "metal": "metal",
        "metal.002": "metal",
        "metal.003": "metal",
        "metal.004": "metal",
    },
    "link3.obj": {"Part__Feature_001_001_001_002": "grey"},
    "link4.obj": {"Part__Feature002_001_003_001": "grey"},
    "link5.obj": {"Shell001_001_001_003.001": "grey"},
    "link6.obj": {"Grey": "grey", "Metal": "metal"},
    "link7.obj": {"Grey": "grey", "Metal": "metal"},
    "hand.obj": {
        "Part__Feature001_008_005": "grey",
        "Part__Feature_009_005": "grey",
        "Part__Feature002_005_005": "metal",
        "Part__Feature005_001_005_001": "metal",
    },
    "finger.obj": {"Part__Feature001_006": "metal", "Part__Feature_007": "grey"},
}
"""Colour of each OBJ material, by file; white where none is named."""

TRIANGLES = 1500
"""Triangles a link, shared among its colours by surface area."""
WELD_M = 1e-4
SMALLEST_PART_M = 0.015


def read_obj(path: Path) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Vertices (V, 3) and, for each material, triangles (F, 3) of a Wavefront OBJ file."""
    vertices: list[list[float]] = []
    triangles: dict[str, list[list[int]]] = {}
    material = ""
    for line in path.read_text().splitlines():
        key, *values = line.split() or [""]
        if key == "v":
            vertices.append([float(value) for value in values[:3]])
        elif key == "usemtl":
            material = values[0]
        elif key == "f":
            corners = [int(value.split("/")[0]) - 1 for value in values]
            fan = ([corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1))
            triangles.setdefault(material, []).extend(fan)
    return np.array(vertices), {name: np.array(faces) for name, faces in triangles.items()}


def reduced_parts(path: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The reduced vertices and triangles of an OBJ file by colour."""
    vertices, by_material = read_obj(path)
    by_color: dict[str, list[np.ndarray]] = {}
    for material, faces in by_material.items():
        by_color.setdefault(PARTS.get(path.name, {}).get(material, "white"), []).append(faces)
    parts: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for color, faces in by_color.items():
        points, triangles = weld(vertices, np.concatenate(faces), WELD_M)
        parts[color] = drop_small_parts(points, triangles, SMALLEST_PART_M)
    area = {color: _area(points, triangles) for color, (points, triangles) in parts.items()}
    return {
        color: decimate(points, triangles, round(TRIANGLES * area[color] / sum(area.values())))
        for color, (points, triangles) in parts.items()
    }


def bake(source: Path, target: Path) -> None:
    """Write one prim a link under `/Visuals`, each with a mesh a colour.

    Args:
        source: Folder of the OBJ files.
        target: USD file to write.

    Raises:
        FileNotFoundError: An OBJ file is missing.
    """
    layer = Sdf.Layer.CreateAnonymous(".usda")
    stage = Usd.Stage.Open(layer)
    layer.documentation = (
        "Visual meshes of the Franka Emika Panda, reduced by scripts/maintainers/mesh_baking.py; see NOTICE."
    )
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Scope.Define(stage, "/Visuals").GetPrim())
    for link, file in SOURCES.items():
        UsdGeom.Xform.Define(stage, f"/Visuals/{link}")
        for color, (vertices, triangles) in reduced_parts(source / file).items():
            if link == "panda_rightfinger":  # a half turn about z
                vertices = vertices * (-1.0, -1.0, 1.0)
            mesh = UsdGeom.Mesh.Define(stage, f"/Visuals/{link}/{link}_{color}")
            points = np.round(vertices, 5).astype(np.float32)
            mesh.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
            mesh.CreateExtentAttr([Gf.Vec3f(*points.min(axis=0).tolist()), Gf.Vec3f(*points.max(axis=0).tolist())])
            mesh.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(len(triangles), 3, dtype=np.int32)))
            mesh.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(triangles.astype(np.int32).ravel()))
            mesh.CreateSubdivisionSchemeAttr("none")
            mesh.CreateDisplayColorAttr([Gf.Vec3f(*COLORS[color])])
    layer.Export(str(target))


def _area(vertices: np.ndarray, triangles: np.ndarray) -> float:
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)
