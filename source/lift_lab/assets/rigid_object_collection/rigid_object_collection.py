"""Collection of rigid objects: a type for configs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lift_lab.utils.errors import ConfigError, quote

from ..asset_base import AssetBase

if TYPE_CHECKING:
    from .rigid_object_collection_cfg import RigidObjectCollectionCfg


class RigidObjectCollection(AssetBase):
    """A type for annotations; making one raises."""

    def __init__(self, cfg: RigidObjectCollectionCfg):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(
            f"rigid object collections are not supported: give {quote(cfg.rigid_objects)} a field of the scene each"
        )
