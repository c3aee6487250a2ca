"""Load a USD file, or lay a ground plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import mujoco

from lift_lab import usd
from lift_lab.isaac.finder import attributes_of
from lift_lab.utils.assets import resolve_usd_path

from ...ignored import note_ignored
from ..appearance import CHECKER, add_checker, apply_appearance
from ..import_notes import log_import
from ..materials.notes import note_ignored_material
from ..spawner_cfg import Spawned

if TYPE_CHECKING:
    from .from_files_cfg import GroundPlaneCfg, UsdFileCfg


def spawn_from_usd(prim_path: str, cfg: UsdFileCfg) -> Spawned:
    """Import ``cfg.usd_path`` (Isaac Lab's ``spawn_from_usd``).

    Args:
        prim_path: path of the asset in the scene; its last part names the asset in messages.
        cfg: the file, its scale and variants. Physics overrides are applied by the scene.

    Raises:
        FileError: the file does not exist.
        UsdImportError: the file cannot be imported.
    """
    variants = cfg.variants
    if variants is not None and not isinstance(variants, dict):
        variants = {k: v for k, v in vars(variants).items() if not k.startswith("_")}
    spec, report = usd.load(resolve_usd_path(cfg.usd_path), variants=variants, scale=cfg.scale)
    log_import(prim_path, report)
    if cfg.semantic_tags:
        note_ignored(f"{prim_path}.semantic_tags", "there are no semantic images")
    apply_appearance(spec, cfg)
    return Spawned(spec, report)


def spawn_ground_plane(prim_path: str, cfg: GroundPlaneCfg) -> Spawned:
    """Lay a horizontal plane with a checker pattern at the origin (Isaac Lab's ``spawn_ground_plane``)."""
    note_ignored_material(prim_path, cfg.physics_material)
    spec = mujoco.MjSpec()
    name = prim_path.rsplit("/", 1)[-1]
    add_checker(spec, None if not cfg.color or not any(cfg.color) else cfg.color)
    spec.worldbody.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[cfg.size[0] / 2, cfg.size[1] / 2, 0.05],
        material=CHECKER,
        friction=[cfg.physics_material.dynamic_friction, 0.005, 0.0001],
    )
    return Spawned(spec)


if TYPE_CHECKING:
    from ....isaac.spawners import spawn_from_mjcf as spawn_from_mjcf
    from ....isaac.spawners import spawn_from_urdf as spawn_from_urdf
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
