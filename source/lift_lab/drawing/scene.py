"""Off-screen frames of one or many environments with MuJoCo's own renderer."""

from __future__ import annotations

import copy
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np

from . import shapes
from .framing import View
from .lighting import Lighting, Sky, prepare_model
from .opengl import Context, DrawError, open_context

_ROOM = 64
"""Geoms that a scene has room for beyond those of the model and the markers."""
_COLOURS = ("geom_rgba", "geom_matid", "mat_rgba", "site_rgba")
"""What may change in a model between two frames."""


@dataclass
class Picture:
    """Contents of one frame: the state of one or many environments, and what is drawn over them."""

    qpos: np.ndarray
    """Positions of the environments drawn, shape (n, nq)."""
    mocap_pos: np.ndarray
    """Positions of the bodies moved by hand in m, shape (n, nmocap, 3)."""
    mocap_quat: np.ndarray
    """Their orientations, shape (n, nmocap, 4)."""
    view: View = field(default_factory=View)
    """Camera, where the drawer has none of the model's."""
    markers: list[shapes.Placed] = field(default_factory=list)
    """Shapes drawn besides, in the frame's coordinates."""
    lines: list[tuple[str, str]] = field(default_factory=list)
    """Text over the picture: label and value of each line."""


class SceneDrawer:
    """Draws frames of one size and model. Bound to the thread that made it."""

    def __init__(
        self,
        model: mujoco.MjModel,
        width: int,
        height: int,
        origins: np.ndarray,
        camera: str | None = None,
        fine: bool = False,
    ):
        """Open an off-screen context.

        Args:
            model: the compiled model of one environment. A copy of it is drawn; colours may be changed between frames.
            width: of a frame in pixels.
            height: of a frame in pixels.
            origins: where each environment stands in the frame in m, shape (n, 3).
            camera: name of a camera of the model, seen in the first environment; None for the picture's view.
            fine: smooth edges and sharp shadows, at about four times the cost.

        Raises:
            DrawError: no OpenGL library could be opened, or there is no such camera.
        """
        self._source, self._model = model, copy.copy(model)
        model = self._model
        self._origins = np.asarray(origins, dtype=np.float32)
        self._camera_id = find_camera(model, camera)
        settings: Any = model.vis
        settings.global_.offwidth, settings.global_.offheight = width, height
        prepare_model(model, fine)
        self._fine = fine
        self._lighting = Lighting(model, self._origins)
        self._data = mujoco.MjData(model)
        self._option, self._perturb = mujoco.MjvOption(), mujoco.MjvPerturb()
        self._scene: mujoco.MjvScene | None = None
        self._grounds = _grounds(model)
        self._context: Context | None = open_context(width, height)
        self._renderer: mujoco.MjrContext | None = None
        self._area = mujoco.MjrRect(0, 0, width, height)
        self._pixels = np.zeros((height, width, 3), dtype=np.uint8)
        self._depth = np.zeros((height, width), dtype=np.float32)
        self._sky = Sky(width, height)

    def draw(self, picture: Picture) -> np.ndarray:
        """Draw one frame, shape (height, width, 3), uint8.

        Raises:
            DrawError: OpenGL cannot draw the scene.
        """
        assert self._context is not None
        self._context.make_current()
        scene, renderer = self._fill(picture)
        behind = self._lighting.add_backdrop(scene) if self._fine else 1.0
        mujoco.mjr_render(self._area, scene, renderer)
        mujoco.mjr_readPixels(self._pixels, self._depth, self._area, renderer)
        nothing = self._depth >= behind
        self._pixels[nothing] = self._sky.behind(scene.camera[0])[nothing]
        if picture.lines:
            labels, values = ("\n".join(column) for column in zip(*picture.lines, strict=True))
            font, corner = mujoco.mjtFont.mjFONT_NORMAL, mujoco.mjtGridPos.mjGRID_TOPLEFT
            mujoco.mjr_drawPixels(self._pixels.reshape(-1, 1), None, self._area, renderer)
            mujoco.mjr_overlay(font, corner, self._area, labels, values, renderer)
            mujoco.mjr_readPixels(self._pixels, None, self._area, renderer)
        return self._pixels[::-1].copy()

    def _fill(self, picture: Picture) -> tuple[mujoco.MjvScene, mujoco.MjrContext]:
        """The scene with every environment and marker in it, and what renders it."""
        model, data = self._model, self._data
        for name in _COLOURS:
            getattr(model, name)[:] = getattr(self._source, name)
        wanted = (model.ngeom + model.nflex + 8) * len(self._origins) + _ROOM
        wanted += sum(placed.num_geoms for placed in picture.markers)
        if self._scene is None or self._scene.maxgeom < wanted:
            self._scene = mujoco.MjvScene(model, wanted)
        scene = self._scene
        every = int(mujoco.mjtCatBit.mjCAT_ALL)
        for k, origin in enumerate(self._origins):
            data.qpos[:] = picture.qpos[k]
            if model.nmocap:
                data.mocap_pos[:], data.mocap_quat[:] = picture.mocap_pos[k], picture.mocap_quat[k]
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_flex(model, data)
            mujoco.mj_tendon(model, data)
            mujoco.mj_camlight(model, data)
            if k == 0:
                camera = self._camera(picture)
                eye, distance = self._stand(picture)
                if self._lighting.set_range(data, eye, distance) or self._renderer is None:
                    self._renderer = self._make_renderer()
                mujoco.mjv_updateScene(model, data, self._option, self._perturb, camera, every, scene)
                self._lighting.light(scene, self._renderer, data, distance)
                self._shift(scene, 0, origin)
            else:
                first = scene.ngeom
                groups = model.geom_group[self._grounds]
                model.geom_group[self._grounds] = mujoco.mjNGROUP - 1  # one ground is enough
                mujoco.mjv_addGeoms(model, data, self._option, self._perturb, every, scene)
                model.geom_group[self._grounds] = groups
                self._shift(scene, first, origin)
        for placed in picture.markers:
            shapes.add(scene, placed)
        assert self._renderer is not None
        return scene, self._renderer

    def _make_renderer(self) -> mujoco.MjrContext:
        if self._renderer is not None:
            self._renderer.free()
        height = self._area.height
        try:
            renderer = mujoco.MjrContext(self._model, 100 if height < 600 else 150 if height < 1000 else 200)
        except (RuntimeError, mujoco.FatalError) as error:
            raise DrawError(f"OpenGL cannot draw this scene: {error}") from error
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, renderer)
        return renderer

    def _camera(self, picture: Picture) -> mujoco.MjvCamera:
        camera = mujoco.MjvCamera()
        if self._camera_id is not None:
            camera.type, camera.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, self._camera_id
            return camera
        view = picture.view
        camera.lookat[:] = view.lookat
        camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth_deg, view.elevation_deg
        return camera

    def _stand(self, picture: Picture) -> tuple[np.ndarray, float]:
        """Position of the camera, and its distance in m from what it looks at: a camera of the model, from the middle
        of the scene."""
        if self._camera_id is not None:
            eye = self._data.cam_xpos[self._camera_id]
            return eye, max(float(np.linalg.norm(eye - self._lighting.centre(self._data))), 0.05)
        view = picture.view
        return np.asarray(view.lookat) - view.distance * view.axes()[0], view.distance

    def _shift(self, scene: mujoco.MjvScene, first: int, origin: np.ndarray) -> None:
        if not origin.any():
            return
        for i in range(first, scene.ngeom):
            scene.geoms[i].pos[:] += origin

    def close(self) -> None:
        """Free the context. May be called again."""
        if self._context is not None:
            if self._renderer is not None:
                self._renderer.free()
            self._context.free()
            self._context = self._renderer = None


def find_camera(model: mujoco.MjModel, name: str | None) -> int | None:
    """Id of a camera whose name is or ends with ``name``.

    Raises:
        DrawError: there is none, or there are several.
    """
    if name is None:
        return None
    names = [model.camera(i).name for i in range(model.ncam)]
    found = [i for i, known in enumerate(names) if known == name or known.endswith(f"/{name}")]
    if len(found) != 1:
        known = f"its cameras: {', '.join(names)}" if names else "it has none"
        raise DrawError(f"the scene has {'no' if not found else 'more than one'} camera '{name}'; {known}")
    return found[0]


def _grounds(model: mujoco.MjModel) -> np.ndarray:
    """Ids of the planes that are fixed to the world."""
    return np.flatnonzero((model.geom_type == int(mujoco.mjtGeom.mjGEOM_PLANE)) & (model.geom_bodyid == 0))
