"""Light, shadows and haze of a drawn scene. Everything here changes a drawing, never a model that is simulated."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from .framing import drawn_geoms

HORIZON, ZENITH, BELOW = (236, 239, 243), (150, 176, 205), (200, 204, 210)
"""Colours of the background: at the horizon, 45 degrees above it, and 45 degrees below it."""
_SUN_TURN_DEG, _SUN_HEIGHT_DEG = 50.0, 55.0
"""Direction of the sun in a scene without lights: to the left of the camera, and above the horizon."""
_SUN, _FILL, _AMBIENT, _SHINE = 0.58, 0.18, 0.32, 0.12
"""Brightness of a scene without lights: of the sun, of the headlight, of what comes from everywhere, of reflections."""
_NEAR, _CLEAR, _HAZE_ENDS = 0.01, 1.5, 6.0
"""Start of the view, start of the haze and depth of the haze, in units of the distance from the camera to its
target."""
_FAR, _BACKDROP = 50.0, 0.8
"""End of the view, in units of the distance to the end of the scene, and place of the backdrop, as a share of that."""
_SHADE = 1.1
"""Half the side of the shadow map, in radii of what casts shadows."""
_DIRECTIONAL = int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)
_PLANE, _DECORATION = int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtCatBit.mjCAT_DECOR)


def prepare_model(model: mujoco.MjModel, fine: bool) -> None:
    """Set the quality of shadows and edges, and a headlight where a scene has no light of its own.

    Args:
        model: a copy that is only drawn. Its settings are changed before the OpenGL context is made.
        fine: smooth edges and sharp shadows.
    """
    settings: Any = model.vis
    settings.quality.shadowsize = 4096 if fine else 1024
    settings.quality.offsamples = 4 if fine else 0
    settings.rgba.fog[:] = (*(c / 255 for c in HORIZON), 1.0)
    if not has_lights(model):
        light = settings.headlight
        light.active = 1
        light.ambient[:], light.diffuse[:], light.specular[:] = _AMBIENT, _FILL, _SHINE


def has_lights(model: mujoco.MjModel) -> bool:
    """Whether a scene has an active light."""
    return bool(np.any(model.light_active)) if model.nlight else False


class Lighting:
    """Lights the scenes of one model."""

    def __init__(self, model: mujoco.MjModel, origins: np.ndarray):
        """Find what casts shadows.

        Args:
            model: the copy that is drawn.
            origins: where each environment stands in the frame in m, shape (n, 3).
        """
        self._model = model
        self._geoms = drawn_geoms(model)
        self._middle = origins.mean(axis=0)
        self._spread = float(np.linalg.norm(origins - self._middle, axis=1).max())
        self._has_lights = has_lights(model)
        self._haze = math.inf

    def set_range(self, data: mujoco.MjData, eye: np.ndarray, distance: float) -> bool:
        """Let the view begin and end where the scene does, and let ground fade behind it, before a scene is filled.

        Args:
            data: state of the first environment.
            eye: position of the camera in m.
            distance: from it to what it looks at in m.

        Returns:
            Whether the haze has changed, which takes a new renderer.
        """
        centre, radius = self._sphere(data)
        far = float(np.linalg.norm(eye - centre)) + radius
        ranges, extent = self._model.vis.map, max(far, distance)
        self._model.stat.extent = extent
        ranges.znear, ranges.zfar = _NEAR * distance / extent, _FAR
        start = max(far, _CLEAR * distance)
        stays = 0.5 < (start + distance) / self._haze < 2.0
        if not stays:
            self._haze = start + distance
            ranges.fogstart, ranges.fogend = start / extent, (start + _HAZE_ENDS * distance) / extent
        return not stays

    def light(self, scene: mujoco.MjvScene, renderer: Any, data: mujoco.MjData, distance: float) -> None:
        """Add the sun where there is no light, and place shadows around what is seen.

        Args:
            scene: filled with the model's own lights.
            renderer: the OpenGL context of the model.
            data: state of the first environment.
            distance: from the camera to what it looks at in m.
        """
        centre, radius = self._sphere(data)
        camera = scene.camera[0]
        eye, ahead = np.asarray(camera.pos, dtype=float), np.asarray(camera.forward, dtype=float)
        if not self._has_lights and scene.nlight < len(scene.lights):
            _add_sun(scene, ahead)
        shade = min(radius, 1.5 * distance)
        spot = centre if shade == radius else eye + distance * ahead
        for i in range(scene.ngeom):
            if scene.geoms[i].type == _PLANE:  # decoration casts no shadows: a large ground shadows parts of itself
                scene.geoms[i].category = _DECORATION
        renderer.shadowClip = _SHADE * shade
        for light in list(scene.lights)[: scene.nlight]:
            if light.type == _DIRECTIONAL and not light.headlight:
                light.pos[:] = spot - 2.0 * radius * np.asarray(light.dir)
        scene.flags[int(mujoco.mjtRndFlag.mjRND_FOG)] = 1

    def add_backdrop(self, scene: mujoco.MjvScene) -> float:
        """Put a wall in haze behind everything, so that smooth edges blend into the sky's colour and not into black.

        Returns:
            Value of the depth buffer, from which on a pixel shows the wall or nothing.
        """
        camera = scene.camera[0]
        ahead, up = np.asarray(camera.forward, dtype=float), np.asarray(camera.up, dtype=float)
        near, far = float(camera.frustum_near), float(camera.frustum_far)
        if scene.ngeom < scene.maxgeom:
            distance = _BACKDROP * far
            axes = np.stack((np.cross(ahead, up), up, -ahead), axis=1)
            half = 2.0 * distance * max(float(camera.frustum_top) / near, 0.1) * 2.0
            position = np.asarray(camera.pos, dtype=float) + distance * ahead
            wall, box = scene.geoms[scene.ngeom], int(mujoco.mjtGeom.mjGEOM_BOX)
            size = np.array((half, half, 1e-3 * distance))
            mujoco.mjv_initGeom(wall, box, size, position, axes.ravel(), np.ones(4, dtype=np.float32))
            wall.category = _DECORATION
            scene.ngeom += 1
        nearest = 0.95 * _BACKDROP * far
        return far * (nearest - near) / (nearest * (far - near))

    def centre(self, data: mujoco.MjData) -> np.ndarray:
        """Middle of everything but the ground in m, shape (3,)."""
        return self._sphere(data)[0]

    def _sphere(self, data: mujoco.MjData) -> tuple[np.ndarray, float]:
        """Centre and radius in m of a ball around everything but the ground."""
        positions = np.concatenate((data.geom_xpos[self._geoms], data.flexvert_xpos.reshape(-1, 3)))
        if not len(positions):
            return np.array(self._middle, dtype=float), 1.0 + self._spread
        centre = (positions.min(axis=0) + positions.max(axis=0)) / 2
        sizes = np.zeros(len(positions))
        sizes[: len(self._geoms)] = self._model.geom_rbound[self._geoms]
        radius = float((np.linalg.norm(positions - centre, axis=1) + sizes).max())
        return centre + self._middle, max(radius, 1e-3) + self._spread


def _add_sun(scene: mujoco.MjvScene, ahead: np.ndarray) -> None:
    """Append a light that casts shadows, over the camera's left shoulder."""
    heading = math.atan2(ahead[1], ahead[0]) - math.radians(_SUN_TURN_DEG)
    height = math.radians(_SUN_HEIGHT_DEG)
    light = scene.lights[scene.nlight]
    light.type, light.headlight, light.castshadow = _DIRECTIONAL, 0, 1
    light.id, light.texid = -1, -1
    light.dir[:] = (math.cos(heading) * math.cos(height), math.sin(heading) * math.cos(height), -math.sin(height))
    light.ambient[:], light.diffuse[:], light.specular[:] = 0.0, _SUN, _SHINE
    light.attenuation[:] = (1.0, 0.0, 0.0)
    light.cutoff, light.exponent, light.softness, light.bulbradius = 180.0, 0.0, 0.0, 0.0
    light.intensity, light.range = 0.0, 0.0
    scene.nlight += 1


class Sky:
    """Background of a scene: a gradient that belongs to the world, so that it meets the ground at the horizon."""

    def __init__(self, width: int, height: int):
        """Compute nothing yet.

        Args:
            width: of the frames in pixels.
            height: of the frames in pixels.
        """
        self._across = np.linspace(-1.0, 1.0, width, dtype=np.float32)[None]
        self._upwards = np.linspace(-1.0, 1.0, height, dtype=np.float32)[:, None]
        self._aspect = width / height
        self._key: tuple[float, ...] | None = None
        self._pixels = np.zeros((height, width, 3), dtype=np.uint8)

    def behind(self, camera: Any) -> np.ndarray:
        """Colours behind a scene, shape (height, width, 3), uint8, rows from the bottom as OpenGL's.

        Args:
            camera: of the scene.
        """
        ahead, up = np.asarray(camera.forward), np.asarray(camera.up)
        slope = camera.frustum_top / camera.frustum_near
        key = tuple(round(float(v), 4) for v in (*ahead, *up, slope))
        if key != self._key:
            self._key = key
            right = np.cross(ahead, up)
            x, y = slope * self._aspect * self._across, slope * self._upwards
            rise = (ahead[2] + x * right[2] + y * up[2]) / np.sqrt(1 + x * x + y * y)
            share = np.clip(np.abs(rise) / math.sin(math.pi / 4), 0.0, 1.0)[..., None]
            horizon, zenith, below = np.array((HORIZON, ZENITH, BELOW), dtype=np.float32)
            far = np.where(rise[..., None] > 0, zenith, below)
            self._pixels = (horizon + share * (far - horizon)).round().astype(np.uint8)
        return self._pixels
