"""What all actuator models share: the joints of a group and their resolved gains and limits."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import torch

from lift_lab.utils.types import ArticulationActions

if TYPE_CHECKING:
    from .actuator_cfg import ActuatorBaseCfg


class ActuatorBase(ABC):
    """A group of joints driven by one model (Isaac Lab's class of this name, with the same hooks to override).

    Tensors have shape (num_envs, num_joints of the group); joint efforts in N m or N.
    """

    is_implicit_model: ClassVar[bool] = False
    """Whether the engine computes the effort."""

    computed_effort: torch.Tensor
    """What the model asked for at the last :meth:`compute`."""
    applied_effort: torch.Tensor
    """What it gave after clipping."""
    effort_limit: torch.Tensor
    velocity_limit: torch.Tensor
    stiffness: torch.Tensor
    damping: torch.Tensor
    armature: torch.Tensor
    friction: torch.Tensor
    dynamic_friction: torch.Tensor
    viscous_friction: torch.Tensor

    def __init__(
        self,
        cfg: ActuatorBaseCfg,
        joint_names: list[str],
        joint_ids: slice | torch.Tensor,
        num_envs: int,
        device: str,
        stiffness: torch.Tensor | float = 0.0,
        damping: torch.Tensor | float = 0.0,
        armature: torch.Tensor | float = 0.0,
        friction: torch.Tensor | float = 0.0,
        dynamic_friction: torch.Tensor | float = 0.0,
        viscous_friction: torch.Tensor | float = 0.0,
        effort_limit: torch.Tensor | float = torch.inf,
        velocity_limit: torch.Tensor | float = torch.inf,
    ):
        """Keep what the articulation resolved from the config and the USD file.

        Args:
            cfg: the group's config.
            joint_names: names of the group's joints.
            joint_ids: their indices in the articulation.
            num_envs: number of environments.
            device: torch device.
            stiffness: and all that follow: one value, or shape (num_envs, num_joints).
        """
        self.cfg = cfg
        self._joint_names = joint_names
        self._joint_indices = joint_ids
        self._num_envs = num_envs
        self._device = device
        values = {
            "stiffness": stiffness,
            "damping": damping,
            "armature": armature,
            "friction": friction,
            "dynamic_friction": dynamic_friction,
            "viscous_friction": viscous_friction,
            "effort_limit": effort_limit,
            "velocity_limit": velocity_limit,
        }
        shape = (num_envs, len(joint_names))
        for name, value in values.items():
            value = torch.as_tensor(value, dtype=torch.float32, device=device)
            setattr(self, name, value.expand(shape).clone())
        self.computed_effort = torch.zeros(shape, device=device)
        self.applied_effort = torch.zeros(shape, device=device)

    @property
    def num_joints(self) -> int:
        """Joints in the group."""
        return len(self._joint_names)

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints in the group."""
        return self._joint_names

    @property
    def joint_indices(self) -> slice | torch.Tensor:
        """Indices of the group's joints in the articulation."""
        return self._joint_indices

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None) -> None:  # noqa: B027 - most have none
        """Forget the internal state of some environments; None means all."""

    def start_episodes(  # noqa: B027 - most have no use for it
        self, env_ids: torch.Tensor, control_action: ArticulationActions
    ) -> None:
        """Take note of the targets with which some environments start, after they were reset.

        Args:
            env_ids: the environments, a LongTensor.
            control_action: targets of the group's joints in these environments.
        """

    @abstractmethod
    def compute(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> ArticulationActions:
        """The effort for targets at a joint state, as ``joint_efforts`` of what is returned.

        Args:
            control_action: position, velocity and effort targets of the group's joints.
            joint_pos: positions in rad or m, shape (num_envs, num_joints).
            joint_vel: velocities in rad/s or m/s, same shape.
        """

    def _clip_effort(self, effort: torch.Tensor) -> torch.Tensor:
        """Clip at the effort limit."""
        return torch.clamp(effort, -self.effort_limit, self.effort_limit)
