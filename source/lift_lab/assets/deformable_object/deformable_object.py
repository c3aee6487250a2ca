"""Deformable objects are named in Isaac Lab's task files and not simulated."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lift_lab.utils.errors import ConfigError

from ..asset_base import AssetBase

if TYPE_CHECKING:
    from .deformable_object_cfg import DeformableObjectCfg


class DeformableObject(AssetBase):
    """A type for annotations; making one raises."""

    def __init__(self, cfg: DeformableObjectCfg):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"'{cfg.prim_path}': deformable objects are not simulated; use RigidObjectCfg")
