"""Deformable objects: one soft body each."""

from .deformable_object import DeformableObject
from .deformable_object_cfg import DeformableObjectCfg
from .deformable_object_data import DeformableObjectData

__all__ = ["DeformableObject", "DeformableObjectCfg", "DeformableObjectData"]
