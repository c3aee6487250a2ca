"""What all actuator models share: the joints of a group and their resolved gains and limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import torch

if TYPE_CHECKING:
    from .actuator_cfg import ActuatorBaseCfg


class ActuatorBase:
    """A group of joints driven by one model.

    Tensors have shape (num_envs, num_joints of the group); joint efforts in N m or N.
    """

    is_implicit_model: ClassVar[bool] = False
    """Whether the engine computes the effort."""

    def __init__(
        self,
        cfg: ActuatorBaseCfg,
        joint_names: list[str],
        joint_ids: torch.Tensor,
        stiffness: torch.Tensor,
        damping: torch.Tensor,
        effort_limit: torch.Tensor,
        velocity_limit: torch.Tensor,
    ):
        self.cfg = cfg
        self._joint_names = joint_names
        self._joint_ids = joint_ids
        self.stiffness = stiffness
        self.damping = damping
        self.effort_limit = effort_limit
        self.velocity_limit = velocity_limit
        self.computed_effort = torch.zeros_like(stiffness)
        self.applied_effort = torch.zeros_like(stiffness)

    @property
    def num_joints(self) -> int:
        """Joints in the group."""
        return len(self._joint_names)

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints in the group."""
        return self._joint_names

    @property
    def joint_indices(self) -> torch.Tensor:
        """Indices of the group's joints in the articulation."""
        return self._joint_ids

    def reset(self, env_ids: torch.Tensor | slice | None) -> None:
        """Forget internal state of some environments. These models have none."""

    def compute(
        self,
        position_target: torch.Tensor,
        velocity_target: torch.Tensor,
        effort_target: torch.Tensor,
        joint_pos: torch.Tensor,
        joint_vel: torch.Tensor,
    ) -> torch.Tensor:
        """Effort of the PD law with feed-forward, clipped; all arguments of the group, shape (num_envs, num_joints)."""
        self.computed_effort = (
            self.stiffness * (position_target - joint_pos)
            + self.damping * (velocity_target - joint_vel)
            + effort_target
        )
        self.applied_effort = self._clip(self.computed_effort, joint_vel)
        return self.applied_effort

    def _clip(self, effort: torch.Tensor, joint_vel: torch.Tensor) -> torch.Tensor:
        return torch.clamp(effort, -self.effort_limit, self.effort_limit)
