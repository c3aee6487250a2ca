"""Visual materials (names of Isaac Lab's)."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import FRACTION, NOT_NEGATIVE, POSITIVE, Ranges


@configclass
class VisualMaterialCfg(ConfigBase):
    """Base of visual materials."""


@configclass
class PreviewSurfaceCfg(VisualMaterialCfg):
    """A UsdPreviewSurface. Colours are linear RGB in [0, 1]."""

    diffuse_color: tuple[float, float, float] = (0.18, 0.18, 0.18)
    """Colour of the surface."""
    emissive_color: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Has no effect."""
    roughness: float = 0.5
    """Has no effect."""
    metallic: float = 0.0
    """Has no effect."""
    opacity: float = 1.0
    """Opacity, from 0 (invisible) to 1."""

    _ranges: ClassVar[Ranges] = {"diffuse_color emissive_color": NOT_NEGATIVE, "roughness metallic opacity": FRACTION}


@configclass
class MdlFileCfg(VisualMaterialCfg):
    """An MDL material: accepted, and drawn in the default colour."""

    mdl_path: str = MISSING
    project_uvw: bool | None = None
    albedo_brightness: float | None = None
    texture_scale: tuple[float, float] | None = None

    _ranges: ClassVar[Ranges] = {"albedo_brightness texture_scale": NOT_NEGATIVE}


@configclass
class GlassMdlCfg(VisualMaterialCfg):
    """Omniverse's glass: accepted, and drawn in the default colour."""

    mdl_path: str = "OmniGlass.mdl"
    glass_color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    frosting_roughness: float = 0.0
    thin_walled: bool = False
    glass_ior: float = 1.491

    _ranges: ClassVar[Ranges] = {"glass_color frosting_roughness": NOT_NEGATIVE, "glass_ior": POSITIVE}
