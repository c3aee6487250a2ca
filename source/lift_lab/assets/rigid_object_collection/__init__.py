"""Collection of rigid objects: config only."""

from .rigid_object_collection import RigidObjectCollection
from .rigid_object_collection_cfg import RigidObjectCollectionCfg

__all__ = ["RigidObjectCollection", "RigidObjectCollectionCfg"]
