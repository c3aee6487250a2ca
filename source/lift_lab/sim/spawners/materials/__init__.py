"""Physics and visual materials of spawned shapes."""

from .physics_materials_cfg import DeformableBodyMaterialCfg, PhysicsMaterialCfg, RigidBodyMaterialCfg
from .visual_materials_cfg import GlassMdlCfg, MdlFileCfg, PreviewSurfaceCfg, VisualMaterialCfg

__all__ = [
    "DeformableBodyMaterialCfg",
    "GlassMdlCfg",
    "MdlFileCfg",
    "PhysicsMaterialCfg",
    "PreviewSurfaceCfg",
    "RigidBodyMaterialCfg",
    "VisualMaterialCfg",
]
