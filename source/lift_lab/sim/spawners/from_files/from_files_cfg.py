"""Configs of spawners that read files (names of Isaac Lab's)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING
from typing import Any, ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, POSITIVE_OR_INF, Ranges

from ... import schemas
from .. import materials
from ..spawner_cfg import DeformableObjectSpawnerCfg, RigidObjectSpawnerCfg, SpawnerCfg
from .from_files import spawn_from_mjcf, spawn_from_urdf, spawn_from_usd, spawn_ground_plane


@configclass
class FileCfg(RigidObjectSpawnerCfg, DeformableObjectSpawnerCfg):
    """Base of spawners that read a file."""

    scale: tuple[float, float, float] | None = None
    """Scale of the asset along its axes."""
    articulation_props: schemas.ArticulationRootPropertiesCfg | None = None
    fixed_tendons_props: schemas.FixedTendonPropertiesCfg | None = None
    spatial_tendons_props: schemas.SpatialTendonPropertiesCfg | None = None
    joint_drive_props: schemas.JointDrivePropertiesCfg | None = None
    visual_material_path: str = "material"
    """Isaac Lab's prim path of the visual material. A label here."""
    visual_material: materials.VisualMaterialCfg | None = None
    """Colour of everything drawn; None keeps the file's."""

    _ranges: ClassVar[Ranges] = {"scale": FINITE}


@configclass
class UsdFileCfg(FileCfg):
    """A USD file (usd, usda, usdc, usdz)."""

    func: Callable = spawn_from_usd
    usd_path: str = MISSING
    """Path of the file, or an Isaac nucleus path that is mapped to a file of ours."""
    variants: object | dict[str, str] | None = None
    """Variant set -> selection, on the default prim."""


@configclass
class GroundPlaneCfg(SpawnerCfg):
    """A ground plane."""

    func: Callable = spawn_ground_plane
    usd_path: str = ""
    """Isaac Lab's grid environment file. Not read: the plane is MuJoCo's."""
    color: tuple[float, float, float] | None = (0.0, 0.0, 0.0)
    size: tuple[float, float] = (100.0, 100.0)
    """Size drawn in m. The plane collides without end."""
    physics_material: materials.RigidBodyMaterialCfg = materials.RigidBodyMaterialCfg()

    _ranges: ClassVar[Ranges] = {"color": NOT_NEGATIVE, "size": POSITIVE_OR_INF}


@configclass
class UrdfFileCfg(FileCfg):
    """A URDF file (data only): spawning one raises."""

    func: Callable = spawn_from_urdf
    asset_path: str = MISSING
    usd_dir: str | None = None
    usd_file_name: str | None = None
    force_usd_conversion: bool = False
    make_instanceable: bool = True
    fix_base: bool = MISSING
    root_link_name: str | None = None
    link_density: float = 0.0
    merge_fixed_joints: bool = True
    convert_mimic_joints_to_normal_joints: bool = False
    joint_drive: Any = None
    collision_from_visuals: bool = False
    collider_type: str = "convex_hull"
    self_collision: bool = False
    replace_cylinders_with_capsules: bool = False

    _ranges: ClassVar[Ranges] = {"link_density": NOT_NEGATIVE}


@configclass
class MjcfFileCfg(FileCfg):
    """An MJCF file (data only): spawning one raises."""

    func: Callable = spawn_from_mjcf
    asset_path: str = MISSING
    usd_dir: str | None = None
    usd_file_name: str | None = None
    force_usd_conversion: bool = False
    make_instanceable: bool = True
    link_density: float = 0.0
    import_inertia_tensor: bool = True
    fix_base: bool = MISSING
    import_sites: bool = True
    self_collision: bool = False

    _ranges: ClassVar[Ranges] = {"link_density": NOT_NEGATIVE}
