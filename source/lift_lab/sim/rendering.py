"""Off-screen frames of one or many environments with MuJoCo's own renderer.

Needs an OpenGL library: set ``MUJOCO_GL=egl`` (or ``osmesa``) before mujoco is imported on a machine without a display.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from lift_lab.utils.errors import PhysicsError

if TYPE_CHECKING:
    from .physics.base import Physics


@dataclass
class RenderView:
    """Camera, size and environments of a frame."""

    env_ids: tuple[int, ...] = (0,)
    """Environments drawn in one frame, each moved by its origin."""
    origins: np.ndarray | None = None
    """Where each drawn environment stands in the frame, shape (len(env_ids), 3); None puts all at zero."""
    lookat: tuple[float, float, float] = (0.35, 0.0, 0.2)
    """Point looked at, in m."""
    distance: float = 1.6
    """Distance from it in m."""
    azimuth_deg: float = 140.0
    elevation_deg: float = -20.0
    width: int = 640
    height: int = 480
    markers: list[tuple[np.ndarray, float, tuple[float, float, float, float]]] = field(default_factory=list)
    """Spheres to draw: (position in m, radius in m, rgba)."""


class FrameRenderer:
    """Draws frames of one size. Bound to the thread that made it."""

    def __init__(self, physics: Physics, view: RenderView):
        """Open an off-screen context.

        Raises:
            PhysicsError: no OpenGL library could be opened.
        """
        self._physics = physics
        model = physics.model
        model.vis.global_.offwidth = max(model.vis.global_.offwidth, view.width)
        model.vis.global_.offheight = max(model.vis.global_.offheight, view.height)
        model.vis.quality.shadowsize = 1024
        model.vis.quality.offsamples = 0
        self._size = (view.width, view.height, len(view.env_ids))
        max_geom = 400 + (model.ngeom + 8) * len(view.env_ids)
        try:
            self._renderer = mujoco.Renderer(model, view.height, view.width, max_geom=max_geom)
        except (RuntimeError, ImportError, AttributeError) as error:
            raise PhysicsError(
                "cannot draw: no OpenGL library was found. On Debian or Ubuntu install libegl1 libgl1-mesa-dri "
                f"libopengl0 and set MUJOCO_GL=egl ({error})"
            ) from error

    def fits(self, view: RenderView) -> bool:
        """Whether this renderer can draw ``view`` (same size, as many environments)."""
        return self._size == (view.width, view.height, len(view.env_ids))

    def draw(self, view: RenderView) -> np.ndarray:
        """Draw one frame, shape (height, width, 3), uint8."""
        camera = mujoco.MjvCamera()
        camera.lookat[:] = view.lookat
        camera.distance = view.distance
        camera.azimuth = view.azimuth_deg
        camera.elevation = view.elevation_deg
        renderer = self._renderer
        option = mujoco.MjvOption()
        for k, env_id in enumerate(view.env_ids):
            data = self._physics.get_data(env_id)
            mujoco.mj_kinematics(self._physics.model, data)
            mujoco.mj_comPos(self._physics.model, data)
            mujoco.mj_camlight(self._physics.model, data)
            if k == 0:
                renderer.update_scene(data, camera, option)
                self._shift(0, view, k)
            else:
                first = renderer.scene.ngeom
                mask = int(mujoco.mjtCatBit.mjCAT_DYNAMIC) | int(mujoco.mjtCatBit.mjCAT_STATIC)
                mujoco.mjv_addGeoms(self._physics.model, data, option, mujoco.MjvPerturb(), mask, renderer.scene)
                self._shift(first, view, k)
        for position, radius, rgba in view.markers:
            self._sphere(position, radius, rgba)
        return renderer.render()

    def _shift(self, first: int, view: RenderView, k: int) -> None:
        if view.origins is None:
            return
        scene = self._renderer.scene
        for i in range(first, scene.ngeom):
            scene.geoms[i].pos[:] += view.origins[k].astype(np.float32)

    def _sphere(self, position: np.ndarray, radius: float, rgba: tuple[float, float, float, float]) -> None:
        scene = self._renderer.scene
        if scene.ngeom >= scene.maxgeom:
            return
        mujoco.mjv_initGeom(
            scene.geoms[scene.ngeom],
            mujoco.mjtGeom.mjGEOM_SPHERE,
            np.array([radius, 0, 0]),
            np.asarray(position, dtype=np.float64),
            np.eye(3).ravel(),
            np.array(rgba, dtype=np.float32),
        )
        scene.ngeom += 1

    def close(self) -> None:
        """Free the context."""
        self._renderer.close()
