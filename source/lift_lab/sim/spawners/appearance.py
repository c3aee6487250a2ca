"""Visibility and colour of a spawned asset."""

from __future__ import annotations

import mujoco

from .materials import PreviewSurfaceCfg


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
