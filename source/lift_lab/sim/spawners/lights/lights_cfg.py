"""Light configs. A dome light becomes light from everywhere and a sun, the others a light of the scene."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Literal

import mujoco

from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, Ranges

from ..spawner_cfg import Spawned, SpawnerCfg

_SKY_AMBIENT, _SKY_SUN, _SKY_SUN_DIR = 0.4, 0.4, (-0.35, 0.25, -1.0)
"""A dome light: brightness of what comes from everywhere, of the sun, and where the sun shines to."""
_LEVEL = 0.7
"""Brightness of every other light."""


def spawn_light(prim_path: str, cfg: LightCfg) -> Spawned:
    """Spawn a light at the origin, shining down the negative z-axis (USD's convention).

    MuJoCo has no light that comes from everywhere and casts shadows. So a dome light becomes ambient light and a sun.
    """
    spec = mujoco.MjSpec()
    name = prim_path.rsplit("/", 1)[-1]
    kinds, is_dome = mujoco.mjtLightType, cfg.prim_type == "DomeLight"
    directional = is_dome or cfg.prim_type == "DistantLight"
    level = _SKY_SUN if is_dome else _LEVEL
    spec.worldbody.add_light(
        name=name,
        type=kinds.mjLIGHT_DIRECTIONAL if directional else kinds.mjLIGHT_POINT,
        pos=[0, 0, 4],
        dir=_SKY_SUN_DIR if is_dome else [0, 0, -1],
        diffuse=[level * c for c in cfg.color],
        ambient=[_SKY_AMBIENT * c for c in cfg.color] if is_dome else [0, 0, 0],
    )
    return Spawned(spec)


@configclass
class LightCfg(SpawnerCfg):
    """Base of lights. Intensity and exposure are photometric in USD; MuJoCo's lights have a fixed level."""

    func: Callable = spawn_light
    prim_type: str = MISSING
    """USD type of the light."""
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Colour in linear RGB, each in [0, 1]."""
    enable_color_temperature: bool = False
    """Has no effect."""
    color_temperature: float = 6500.0
    """Colour temperature in K. Has no effect."""
    normalize: bool = False
    """Has no effect."""
    exposure: float = 0.0
    """Has no effect."""
    intensity: float = 1.0
    """Has no effect."""

    _ranges: ClassVar[Ranges] = {"color color_temperature intensity": NOT_NEGATIVE, "exposure": FINITE}


@configclass
class DiskLightCfg(LightCfg):
    """A disk that emits light."""

    prim_type = "DiskLight"
    radius: float = 0.5

    _ranges: ClassVar[Ranges] = {"radius": NOT_NEGATIVE}


@configclass
class DistantLightCfg(LightCfg):
    """A light at infinity, such as the sun."""

    prim_type = "DistantLight"
    angle: float = 0.53

    _ranges: ClassVar[Ranges] = {"angle": NOT_NEGATIVE}


@configclass
class DomeLightCfg(LightCfg):
    """A sky."""

    prim_type = "DomeLight"
    texture_file: str | None = None
    texture_format: Literal["automatic", "latlong", "mirroredBall", "angular", "cubeMapVerticalCross"] = "automatic"
    visible_in_primary_ray: bool = True


@configclass
class CylinderLightCfg(LightCfg):
    """A tube that emits light."""

    prim_type = "CylinderLight"
    length: float = 1.0
    radius: float = 0.5
    treat_as_line: bool = False

    _ranges: ClassVar[Ranges] = {"length radius": NOT_NEGATIVE}


@configclass
class SphereLightCfg(LightCfg):
    """A ball that emits light."""

    prim_type = "SphereLight"
    radius: float = 0.5
    treat_as_point: bool = False

    _ranges: ClassVar[Ranges] = {"radius": NOT_NEGATIVE}
