"""Shapes of a marker's spawner, as primitives that MuJoCo's renderer draws."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from lift_lab.drawing import shapes
from lift_lab.sim import spawners
from lift_lab.sim.spawners.appearance import linear_to_srgb

FRAME = "frame_prim.usd"
"""Isaac Sim's coordinate frame, known by its file's name."""
ARROW = "arrow_x.usd"
"""Isaac Sim's arrow along x, known by its file's name."""

_GREY = (0.5, 0.5, 0.5, 1.0)
_MOST_TRIANGLES = 500
"""Meshes with more are drawn as their box."""
_SOLIDS = (shapes.SPHERE, shapes.ELLIPSOID, shapes.BOX, shapes.CYLINDER, shapes.CAPSULE)


def primitives(cfg: spawners.SpawnerCfg) -> list[shapes.Primitive]:
    """The primitives that a spawner's shape is drawn with, in its frame; none if it is not visible.

    A USD file is drawn with its own geoms: meshes of up to 500 triangles as they are, larger ones as their boxes.
    """
    if not cfg.visible:
        return []
    file = str(getattr(cfg, "usd_path", "")).rsplit("/", 1)[-1]
    scale = getattr(cfg, "scale", None) or (1.0, 1.0, 1.0)
    rgba = _colour(cfg)
    if file == FRAME:
        return shapes.frame(scale)
    if file == ARROW:
        return shapes.arrow(scale, rgba)
    if isinstance(cfg, spawners.SphereCfg):
        return [shapes.primitive(shapes.ELLIPSOID, (cfg.radius, cfg.radius, cfg.radius), rgba)]
    if isinstance(cfg, spawners.CuboidCfg):
        return [shapes.primitive(shapes.BOX, (cfg.size[0] / 2, cfg.size[1] / 2, cfg.size[2] / 2), rgba)]
    if isinstance(cfg, spawners.ConeCfg):
        return shapes.cone(cfg.radius, cfg.height, cfg.axis, rgba)
    if isinstance(cfg, (spawners.CylinderCfg, spawners.CapsuleCfg)):
        kind = shapes.CYLINDER if isinstance(cfg, spawners.CylinderCfg) else shapes.CAPSULE
        return [shapes.primitive(kind, (cfg.radius, cfg.radius, cfg.height / 2), rgba, axis=cfg.axis)]
    return _of_model(cfg.func("/marker", cfg).spec.compile())


def _colour(cfg: Any) -> tuple[float, float, float, float]:
    material = getattr(cfg, "visual_material", None)
    if not isinstance(material, spawners.PreviewSurfaceCfg):
        return _GREY
    red, green, blue = (linear_to_srgb(channel) for channel in material.diffuse_color)
    return red, green, blue, material.opacity


def _of_model(model: mujoco.MjModel) -> list[shapes.Primitive]:
    """The geoms of a model that its viewer would show, at the model's default positions."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    found = []
    for geom in range(model.ngeom):
        kind, size = int(model.geom_type[geom]), model.geom_size[geom]
        mat, position = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
        material = model.geom_matid[geom]
        rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
        if model.geom_group[geom] > 2 or rgba[3] == 0.0:
            continue
        colour = np.asarray(rgba, float)
        mesh = model.geom_dataid[geom]
        if kind == int(mujoco.mjtGeom.mjGEOM_MESH) and model.mesh_facenum[mesh] <= _MOST_TRIANGLES:
            first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
            corners = model.mesh_vert[model.mesh_vertadr[mesh] + model.mesh_face[first : first + count]]
            found += [shapes.triangle(tuple(three), colour) for three in position + corners @ mat.T]
        elif kind in _SOLIDS:
            lengths = {
                shapes.SPHERE: (size[0],) * 3,
                shapes.CYLINDER: (size[0], size[0], size[1]),
                shapes.CAPSULE: (size[0], size[0], size[1]),
            }.get(kind, size)
            drawn = shapes.ELLIPSOID if kind == shapes.SPHERE else kind
            found.append(shapes.Primitive(drawn, np.array(lengths, float), position.copy(), mat.copy(), colour))
        else:
            centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
            found.append(shapes.Primitive(shapes.BOX, half.copy(), position + mat @ centre, mat.copy(), colour))
    return found
