"""Visibility and colour of a spawned asset, and the pattern of grounds."""

from __future__ import annotations

import mujoco

from .materials import PreviewSurfaceCfg

CHECKER = "ground_checker"
"""Material and texture of grounds that have none of their own."""
_LIGHT_SQUARES, _DARKER = (0.70, 0.72, 0.75), 0.87
"""Colour of every second square, and how much darker the others are."""
_UNCOLOURED = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom that nobody coloured."""


def linear_to_srgb(value: float) -> float:
    """One linear colour channel in [0, 1] as sRGB (IEC 61966-2-1)."""
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


def apply_appearance(spec: mujoco.MjSpec, cfg: object) -> None:
    """Colour or hide the visual geoms of ``spec`` as a spawner's ``visual_material`` and ``visible`` say."""
    visuals = [geom for geom in spec.geoms if not (geom.contype or geom.conaffinity)] or list(spec.geoms)
    material = getattr(cfg, "visual_material", None)
    if isinstance(material, PreviewSurfaceCfg):
        for geom in visuals:
            geom.material = ""
            geom.rgba = [*(linear_to_srgb(c) for c in material.diffuse_color), material.opacity]
    if not getattr(cfg, "visible", True):
        for geom in spec.geoms:
            geom.group = 4


def add_checker(spec: mujoco.MjSpec, color: tuple[float, float, float] | None = None) -> None:
    """Add the material :data:`CHECKER`, with squares of 0.5 m.

    Args:
        spec: may have the material already; then nothing is added.
        color: of the light squares, in [0, 1]; None for a light grey.
    """
    if spec.material(CHECKER) is not None:
        return
    light = _LIGHT_SQUARES if color is None else color
    spec.add_texture(
        name=CHECKER,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=list(light),
        rgb2=[_DARKER * c for c in light],
        width=256,
        height=256,
    )
    material = spec.add_material(name=CHECKER, texrepeat=[1, 1], texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = CHECKER


def add_checker_to_planes(spec: mujoco.MjSpec) -> None:
    """Give the planes of the world that have neither material nor colour the material :data:`CHECKER`."""
    for geom in spec.worldbody.geoms:
        plain = not geom.material and tuple(round(float(c), 6) for c in geom.rgba) == _UNCOLOURED
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE and plain:
            add_checker(spec)
            geom.material = CHECKER
