"""State of an articulation: its bodies' (see :class:`BodyData`) and its joints'."""

from __future__ import annotations

from typing import Any, ClassVar

import torch

from ..asset_base import take_columns
from ..asset_data import cached
from ..body_data import BodyData


class ArticulationData(BodyData):
    """Joint tensors have shape (num_envs, num_joints); rad or m, rad/s or m/s, N m or N."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_dof_cols", "_qpos_cols", "joint_names"})

    joint_names: list[str]
    default_joint_pos: torch.Tensor
    """Default joint positions."""
    default_joint_vel: torch.Tensor
    """Default joint velocities."""
    joint_pos_target: torch.Tensor
    """Position targets as set by the user."""
    joint_vel_target: torch.Tensor
    """Velocity targets as set by the user."""
    joint_effort_target: torch.Tensor
    """Feed-forward efforts as set by the user."""
    joint_stiffness: torch.Tensor
    joint_damping: torch.Tensor
    joint_armature: torch.Tensor
    joint_friction_coeff: torch.Tensor
    """Dry friction efforts (MuJoCo's frictionloss)."""
    joint_viscous_friction_coeff: torch.Tensor
    """Efforts per velocity (MuJoCo's joint damping)."""
    joint_pos_limits: torch.Tensor
    """Lower and upper limits, shape (num_envs, num_joints, 2)."""
    soft_joint_pos_limits: torch.Tensor
    """Soft limits, shape (num_envs, num_joints, 2)."""
    joint_vel_limits: torch.Tensor
    soft_joint_vel_limits: torch.Tensor
    joint_effort_limits: torch.Tensor
    """Effort limits of the engine. For a force range that is not symmetric this is the greater side. It is infinite
    without a limit, and 1e9 for explicit models without ``effort_limit_sim`` (as Isaac Lab)."""
    gear_ratio: torch.Tensor
    default_joint_stiffness: torch.Tensor
    default_joint_damping: torch.Tensor
    default_joint_armature: torch.Tensor
    default_joint_friction_coeff: torch.Tensor
    default_joint_viscous_friction_coeff: torch.Tensor
    default_joint_pos_limits: torch.Tensor
    """Limits at start, shape (num_envs, num_joints, 2)."""

    def __init__(self, *args: Any, qpos_cols: slice | torch.Tensor, dof_cols: slice | torch.Tensor, **kwargs: Any):
        super().__init__(*args, **kwargs)
        self._qpos_cols, self._dof_cols = qpos_cols, dof_cols
        self.explicit_ids: torch.Tensor | None = None
        """Joints whose actuator model is computed in torch, ascending, shape (n,); None without any."""
        self.explicit_computed: torch.Tensor | None = None
        """What those models asked for at the last physics step, shape (num_envs, n)."""
        self.explicit_effort: torch.Tensor | None = None
        """What those models gave at the last physics step, after clipping, shape (num_envs, n)."""
        self.constant_effort: torch.Tensor | None = None
        """Constant efforts that the file's drives add, shape (num_envs, num_joints); None without any."""
        self.target_ranges: dict[str, tuple[torch.Tensor, torch.Tensor]] = {}
        """Lowest and highest ``position`` and ``velocity`` targets of the file's drives, where it limits them."""
        self.effort_range: tuple[torch.Tensor, torch.Tensor] | None = None
        """Lowest and highest effort of each joint, where a file's force range is lopsided."""

    @property
    def joint_pos(self) -> torch.Tensor:
        """Joint positions (a live view where the engine stores them side by side)."""
        cols = self._qpos_cols
        return self._physics.field("qpos")[:, cols] if isinstance(cols, slice) else self._scattered_pos

    @property
    def joint_vel(self) -> torch.Tensor:
        """Joint velocities (a live view where the engine stores them side by side)."""
        cols = self._dof_cols
        return self._physics.field("qvel")[:, cols] if isinstance(cols, slice) else self._scattered_vel

    @property
    def joint_acc(self) -> torch.Tensor:
        """Joint accelerations: the change of the velocities over the last physics substep; zero after a reset."""
        return take_columns(self._physics.acceleration(), self._dof_cols)

    @cached
    def _scattered_pos(self) -> torch.Tensor:
        return take_columns(self._physics.field("qpos"), self._qpos_cols)

    @cached
    def _scattered_vel(self) -> torch.Tensor:
        return take_columns(self._physics.field("qvel"), self._dof_cols)

    @cached
    def computed_torque(self) -> torch.Tensor:
        """Effort that the actuator models ask for at the current state, before clipping."""
        effort = (
            self.joint_stiffness * (self.clip_target("position", self.joint_pos_target) - self.joint_pos)
            + self.joint_damping * (self.clip_target("velocity", self.joint_vel_target) - self.joint_vel)
            + self.joint_effort_target
        )
        if self.constant_effort is not None:
            effort = effort + self.constant_effort
        if self.explicit_ids is not None and self.explicit_computed is not None:
            effort[:, self.explicit_ids] = self.explicit_computed
        return effort

    def clip_target(self, kind: str, target: torch.Tensor) -> torch.Tensor:
        """Targets within the ranges that the asset's file gives its drives."""
        return target.clamp(*self.target_ranges[kind]) if kind in self.target_ranges else target

    @cached
    def applied_torque(self) -> torch.Tensor:
        """Effort that the actuator models give at the current state, clipped at the effort limits."""
        limit = self.joint_effort_limits
        low, high = (-limit, limit) if self.effort_range is None else self.effort_range
        effort = torch.clamp(self.computed_torque, low, high)
        if self.explicit_ids is not None and self.explicit_effort is not None:
            effort[:, self.explicit_ids] = self.explicit_effort
        return effort

    @property
    def joint_limits(self) -> torch.Tensor:
        """Isaac Lab's older name for :attr:`joint_pos_limits`."""
        return self.joint_pos_limits

    @property
    def default_joint_limits(self) -> torch.Tensor:
        """Isaac Lab's older name for :attr:`default_joint_pos_limits`."""
        return self.default_joint_pos_limits

    @property
    def joint_velocity_limits(self) -> torch.Tensor:
        """Isaac Lab's older name for :attr:`joint_vel_limits`."""
        return self.joint_vel_limits

    @property
    def joint_friction(self) -> torch.Tensor:
        """Isaac Lab's older name for :attr:`joint_friction_coeff`."""
        return self.joint_friction_coeff

    @property
    def default_joint_friction(self) -> torch.Tensor:
        """Isaac Lab's older name for :attr:`default_joint_friction_coeff`."""
        return self.default_joint_friction_coeff
