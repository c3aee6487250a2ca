"""Config of a deformable object (data only)."""

from __future__ import annotations

from lift_lab.utils import configclass

from ..asset_base_cfg import AssetBaseCfg
from .deformable_object import DeformableObject


@configclass
class DeformableObjectCfg(AssetBaseCfg):
    """A deformable object: accepted as data; building a scene with one raises."""

    class_type: type = DeformableObject
