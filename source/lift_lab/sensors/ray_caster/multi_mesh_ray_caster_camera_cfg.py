"""Isaac Lab's module path of this config."""

from .multi_mesh_ray_caster_cfg import MultiMeshRayCasterCameraCfg

__all__ = ["MultiMeshRayCasterCameraCfg"]
