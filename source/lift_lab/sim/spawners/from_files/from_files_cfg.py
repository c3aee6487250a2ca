"""Configs of spawners that read files (names of Isaac Lab's)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

from lift_lab.isaac.finder import attributes_of
from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, POSITIVE_OR_INF, Ranges

from ... import schemas
from .. import materials
from ..spawner_cfg import DeformableObjectSpawnerCfg, RigidObjectSpawnerCfg, SpawnerCfg
from .from_files import spawn_from_usd, spawn_ground_plane


@configclass
class FileCfg(RigidObjectSpawnerCfg, DeformableObjectSpawnerCfg):
    """Base of spawners that read a file."""

    scale: tuple[float, float, float] | None = None
    """Scale of the asset along its axes."""
    articulation_props: schemas.ArticulationRootPropertiesCfg | None = None
    """Properties of the articulation's root."""
    fixed_tendons_props: schemas.FixedTendonPropertiesCfg | None = None
    """Properties of PhysX fixed tendons: ignored."""
    spatial_tendons_props: schemas.SpatialTendonPropertiesCfg | None = None
    """Properties of PhysX spatial tendons: ignored."""
    joint_drive_props: schemas.JointDrivePropertiesCfg | None = None
    """Properties of the joint drives."""
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
    """Colour of the checker's light squares. None and black (Isaac Lab's default) give a light grey."""
    size: tuple[float, float] = (100.0, 100.0)
    """Size drawn in m. The plane collides without end."""
    physics_material: materials.RigidBodyMaterialCfg = materials.RigidBodyMaterialCfg()
    """Friction of the ground."""

    _ranges: ClassVar[Ranges] = {"color": NOT_NEGATIVE, "size": POSITIVE_OR_INF}


if TYPE_CHECKING:
    from ....isaac.spawners import MjcfFileCfg as MjcfFileCfg
    from ....isaac.spawners import UrdfFileCfg as UrdfFileCfg
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
