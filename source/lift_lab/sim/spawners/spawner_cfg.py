"""Base classes of spawners: configs whose ``func`` turns them into a MjSpec of one asset."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import mujoco

from lift_lab.utils import MISSING, ConfigBase, configclass

from .. import schemas

if TYPE_CHECKING:
    from lift_lab.usd import ImportReport

__all__ = ["DeformableObjectSpawnerCfg", "RigidObjectSpawnerCfg", "Spawned", "SpawnerCfg"]


@dataclass
class Spawned:
    """One asset, ready to be attached to a scene."""

    spec: mujoco.MjSpec
    """The asset alone, its root bodies and static geoms under the world body."""
    report: ImportReport | None = None
    """Report of the USD importer on what it read, ignored and approximated; None for other spawners."""


@configclass
class SpawnerCfg(ConfigBase):
    """Base of all spawners (Isaac Lab's ``SpawnerCfg``)."""

    func: Callable[..., Spawned] = MISSING
    """Called as ``func(prim_path, cfg)``; returns a :class:`Spawned`."""
    visible: bool = True
    """Whether the asset is drawn."""
    semantic_tags: list[tuple[str, str]] | None = None
    """Isaac Lab's labels for synthetic images: accepted, and reported as ignored."""
    copy_from_source: bool = True
    """Isaac Lab's cloning switch: worlds always share one model here."""


@configclass
class RigidObjectSpawnerCfg(SpawnerCfg):
    """A spawner of rigid bodies, with overrides of their physics."""

    mass_props: schemas.MassPropertiesCfg | None = None
    """Mass or density."""
    rigid_props: schemas.RigidBodyPropertiesCfg | None = None
    """Properties of the rigid bodies."""
    collision_props: schemas.CollisionPropertiesCfg | None = None
    """Properties of the colliders."""
    activate_contact_sensors: bool = False
    """Isaac Lab's switch for contact reporting. Contacts can always be read here."""


@configclass
class DeformableObjectSpawnerCfg(SpawnerCfg):
    """A spawner of deformable bodies, for :class:`lift_lab.assets.DeformableObjectCfg`."""

    mass_props: schemas.MassPropertiesCfg | None = None
    """Mass or density."""
    deformable_props: schemas.DeformableBodyPropertiesCfg | None = None
    """Properties of the deformable body."""
