"""Retargeters for arms with grippers: configs only."""

from .gripper_retargeter import GripperRetargeter, GripperRetargeterCfg
from .se3_abs_retargeter import Se3AbsRetargeter, Se3AbsRetargeterCfg
from .se3_rel_retargeter import Se3RelRetargeter, Se3RelRetargeterCfg

__all__ = [
    "GripperRetargeter",
    "GripperRetargeterCfg",
    "Se3AbsRetargeter",
    "Se3AbsRetargeterCfg",
    "Se3RelRetargeter",
    "Se3RelRetargeterCfg",
]
