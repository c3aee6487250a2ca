"""Lights (names of Isaac Lab's)."""

from .lights_cfg import (
    CylinderLightCfg,
    DiskLightCfg,
    DistantLightCfg,
    DomeLightCfg,
    LightCfg,
    SphereLightCfg,
)

__all__ = [
    "CylinderLightCfg",
    "DiskLightCfg",
    "DistantLightCfg",
    "DomeLightCfg",
    "LightCfg",
    "SphereLightCfg",
]
