"""Default pose of a camera: it frames the robots and objects of a scene."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass

import mujoco
import numpy as np

FILL = 0.66
"""Share of the frame's height or width that the framed objects fill; the larger of the two shares."""
DIRECTION_DEG = (215.0, -22.0)
"""Azimuth and elevation of the default view: from the front left, above."""
FOV_DEG = 45.0
"""Vertical field of view of MuJoCo's free camera."""
_DRAWN_GROUPS = 3
"""Geoms of higher groups are not drawn."""
_ROUND = (int(mujoco.mjtGeom.mjGEOM_SPHERE), int(mujoco.mjtGeom.mjGEOM_ELLIPSOID))
_CORNERS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
_SPHERE = np.array([d for d in itertools.product(np.linspace(-1, 1, 7), repeat=3) if 1.0 in np.abs(d)])
_SPHERE /= np.linalg.norm(_SPHERE, axis=1, keepdims=True)


@dataclass
class View:
    """A camera that turns about a point."""

    lookat: tuple[float, float, float] = (0.35, 0.0, 0.2)
    """Point looked at, in m."""
    distance: float = 1.6
    """Distance from it in m."""
    azimuth_deg: float = 140.0
    elevation_deg: float = -20.0

    def axes(self) -> np.ndarray:
        """Unit vectors ahead, to the right and up, as rows, shape (3, 3)."""
        azimuth, elevation = np.radians((self.azimuth_deg, self.elevation_deg))
        ahead = np.array((np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)))
        right = np.array((np.sin(azimuth), -np.cos(azimuth), 0.0))
        return np.stack((ahead, right, np.cross(right, ahead)))


def drawn_geoms(model: mujoco.MjModel) -> np.ndarray:
    """Ids of the geoms that are drawn, without planes and height fields, which may have no end."""
    alpha = np.where(model.geom_matid >= 0, model.mat_rgba[model.geom_matid, 3] if model.nmat else 1.0, 1.0)
    alpha = np.where(model.geom_matid >= 0, alpha, model.geom_rgba[:, 3])
    endless = np.isin(model.geom_type, (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD)))
    return np.flatnonzero((model.geom_group < _DRAWN_GROUPS) & (alpha > 0) & ~endless)


def moving_geoms(model: mujoco.MjModel) -> np.ndarray:
    """Ids of the drawn geoms of robots and objects: everything that is fixed to something with a joint.

    Without any, all that are drawn.
    """
    moves = np.zeros(model.nbody, dtype=bool)
    moves[model.body_rootid[model.body_dofnum > 0]] = True
    moves[model.body_rootid[model.body_mocapid >= 0]] = True
    drawn = drawn_geoms(model)
    found = drawn[moves[model.body_rootid[model.geom_bodyid[drawn]]]]
    return found if len(found) or model.nflexvert else drawn


def corners(model: mujoco.MjModel, data: mujoco.MjData, geoms: Iterable[int]) -> np.ndarray:
    """Outermost points of geoms, and the vertices of every soft body, in the world in m, shape (n, 3).

    Of spheres and ellipsoids they are points of the surface, of other geoms the corners of the box around them.
    """
    ids = np.fromiter(geoms, dtype=int)
    is_round = np.isin(model.geom_type[ids], _ROUND)
    found = [data.flexvert_xpos.reshape(-1, 3)]
    for some, directions in ((ids[~is_round], _CORNERS), (ids[is_round], _SPHERE)):
        local = model.geom_aabb[some, None, :3] + model.geom_aabb[some, None, 3:] * directions
        turned = local @ data.geom_xmat[some].reshape(-1, 3, 3).transpose(0, 2, 1)
        found.append((turned + data.geom_xpos[some, None]).reshape(-1, 3))
    return np.concatenate(found)


def fit(points: np.ndarray, aspect: float, fov_deg: float = FOV_DEG, fill: float = FILL) -> View:
    """The view from :data:`DIRECTION_DEG` in which points fill a share of the frame and are in its middle.

    Args:
        points: in m, shape (n, 3), n > 0.
        aspect: width of the frame over its height.
        fov_deg: vertical field of view of the camera.
        fill: share of the frame's height or width.
    """
    view = View((0.0, 0.0, 0.0), 1.0, *DIRECTION_DEG)
    ahead, right, up = (points @ view.axes().T).T
    reach = fill * np.tan(np.radians(fov_deg) / 2)
    # On each side the nearest camera that still sees all: distance >= +-(across - shift) / slope - ahead
    distance, shifts = 0.0, []
    for across, slope in ((right, reach * aspect), (up, reach)):
        high, low = (across / slope - ahead).max(), (-across / slope - ahead).max()
        shifts.append(slope * (high - low) / 2)
        distance = max(distance, (high + low) / 2)
    # The camera stands `distance` behind the origin's plane; it looks at the middle of the points.
    middle = (ahead.min() + ahead.max()) / 2
    lookat = np.array((middle, *shifts)) @ view.axes()
    size = float(np.ptp(points, axis=0).max())
    return View(
        (float(lookat[0]), float(lookat[1]), float(lookat[2])), max(distance + middle, size, 1e-3), *DIRECTION_DEG
    )
