"""Retargeters: configs only."""

from .manipulator import (
    GripperRetargeter,
    GripperRetargeterCfg,
    Se3AbsRetargeter,
    Se3AbsRetargeterCfg,
    Se3RelRetargeter,
    Se3RelRetargeterCfg,
)

__all__ = [
    "GripperRetargeter",
    "GripperRetargeterCfg",
    "Se3AbsRetargeter",
    "Se3AbsRetargeterCfg",
    "Se3RelRetargeter",
    "Se3RelRetargeterCfg",
]
