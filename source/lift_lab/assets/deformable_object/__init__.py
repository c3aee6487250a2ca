"""Deformable objects: configs only."""

from .deformable_object import DeformableObject
from .deformable_object_cfg import DeformableObjectCfg

__all__ = ["DeformableObject", "DeformableObjectCfg"]
