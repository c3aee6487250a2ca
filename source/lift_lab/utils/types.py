"""Small data types that several packages share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import torch


@dataclass
class ArticulationActions:
    """Joint commands that pass through an actuator model. None where there is no such command."""

    joint_positions: torch.Tensor | None = None
    """Joint positions in rad or m. Shape is (num_envs, num_joints)."""
    joint_velocities: torch.Tensor | None = None
    """Joint velocities in rad/s or m/s. Shape is (num_envs, num_joints)."""
    joint_efforts: torch.Tensor | None = None
    """Joint efforts in N m or N. Shape is (num_envs, num_joints)."""
    joint_indices: torch.Tensor | Sequence[int] | slice | None = None
    """The joints; a slice stands for all joints of the articulation."""


__all__ = ["ArticulationActions"]
