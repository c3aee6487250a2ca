"""Config of a collection of rigid objects (data only)."""

from __future__ import annotations

from dataclasses import MISSING

from lift_lab.utils import configclass

from ..asset_base_cfg import AssetBaseCfg
from ..rigid_object import RigidObjectCfg
from .rigid_object_collection import RigidObjectCollection


@configclass
class RigidObjectCollectionCfg(AssetBaseCfg):
    """Collection of rigid objects: accepted as data; building a scene with one raises."""

    class_type: type = RigidObjectCollection
    prim_path: str = ""
    rigid_objects: dict[str, RigidObjectCfg] = MISSING
