"""Configs of ray casters against moving meshes (data only)."""

from __future__ import annotations

from dataclasses import MISSING

from lift_lab.utils import configclass

from .ray_caster_camera_cfg import RayCasterCameraCfg
from .ray_caster_cfg import RayCasterCfg


@configclass
class MultiMeshRayCasterCfg(RayCasterCfg):
    """Rays against several meshes: accepted as data; building a scene with one raises."""

    @configclass
    class RaycastTargetCfg:
        """One of the meshes."""

        prim_expr: str = MISSING
        is_shared: bool = False
        merge_prim_meshes: bool = True
        track_mesh_transforms: bool = True

    mesh_prim_paths: list[str | RaycastTargetCfg] = MISSING
    update_mesh_ids: bool = False
    reference_meshes: bool = True


@configclass
class MultiMeshRayCasterCameraCfg(RayCasterCameraCfg, MultiMeshRayCasterCfg):
    """A camera of such rays: accepted as data; building a scene with one raises."""
