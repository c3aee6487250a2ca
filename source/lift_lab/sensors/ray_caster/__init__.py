"""Ray casters: configs only."""

from . import patterns
from .multi_mesh_ray_caster_cfg import MultiMeshRayCasterCameraCfg, MultiMeshRayCasterCfg
from .ray_caster import RayCaster
from .ray_caster_camera import RayCasterCamera
from .ray_caster_camera_cfg import RayCasterCameraCfg
from .ray_caster_cfg import RayCasterCfg

__all__ = [
    "MultiMeshRayCasterCameraCfg",
    "MultiMeshRayCasterCfg",
    "RayCaster",
    "RayCasterCamera",
    "RayCasterCameraCfg",
    "RayCasterCfg",
    "patterns",
]
