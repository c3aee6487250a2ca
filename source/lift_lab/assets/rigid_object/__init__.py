"""Rigid objects: one free (or kinematic) body each."""

from .rigid_object import RigidObject
from .rigid_object_cfg import RigidObjectCfg
from .rigid_object_data import RigidObjectData

__all__ = ["RigidObject", "RigidObjectCfg", "RigidObjectData"]
