"""Joint position actions whose range [-1, 1] spans the joints' soft limits."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import torch

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.indexing import columns, compact_index
from lift_lab.utils.io_descriptors import GenericActionIODescriptor

from .joint_actions import clip_limits, clipped, first_row, values_of_names
from .stored_action import StoredAction

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedEnv
    from lift_lab.utils.indexing import EnvIds

    from . import actions_cfg

__all__ = [
    "EMAJointPositionToLimitsAction",
    "JointPositionToLimitsAction",
]


class JointPositionToLimitsAction(StoredAction):
    """Scale and clip the action, cut it to [-1, 1] and map that onto the joints' soft position limits."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_joint_ids", "_joint_names", "_num_joints"})

    _asset: Articulation

    constant_over_substeps = True

    def __init__(self, cfg: actions_cfg.JointPositionToLimitsActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        ids, self._joint_names = self._asset.find_joints(cfg.joint_names, preserve_order=cfg.preserve_order)
        self._num_joints = len(ids)
        self._joint_ids = compact_index(ids, self._asset.num_joints, self.device)
        self._raw_actions = torch.zeros(self.num_envs, self.action_dim, device=self.device)
        self._processed_actions = torch.zeros_like(self._raw_actions)
        self._scale = values_of_names(cfg.scale, self._joint_names, 1.0, self.num_envs, self.device)
        self._clip = clip_limits(cfg.clip, self._joint_names, self.num_envs, self.device)

    @property
    def action_dim(self) -> int:
        """Number of joints."""
        return self._num_joints

    @property
    def IO_descriptor(self) -> GenericActionIODescriptor:
        """Adds ``joint_names``, ``scale`` and ``clip``, and the limits in ``extras``."""
        descriptor = super().IO_descriptor
        descriptor.action_type, descriptor.joint_names = "JointAction", list(self._joint_names)
        descriptor.scale, descriptor.offset, descriptor.clip = first_row(self._scale), 0.0, first_row(self._clip)
        lower, upper = self._limits()
        limits = {"lower": first_row(lower), "upper": first_row(upper)}
        descriptor.extras |= {"rescale_to_limits": self.cfg.rescale_to_limits, **limits}
        return descriptor

    def process_actions(self, actions: torch.Tensor) -> None:
        """Compute the position targets."""
        self._raw_actions[:] = actions
        self._processed_actions = clipped(self._raw_actions * self._scale, self._clip)
        if self.cfg.rescale_to_limits:
            lower, upper = self._limits()
            unit = self._processed_actions.clamp(-1.0, 1.0)
            self._processed_actions = lower + 0.5 * (unit + 1.0) * (upper - lower)

    def apply_actions(self) -> None:
        """Set the position targets."""
        self._asset.set_joint_position_target(self._processed_actions, joint_ids=self._joint_ids)

    def reset(self, env_ids: EnvIds = None) -> None:
        """Forget the raw action of some environments."""
        self._raw_actions[slice(None) if env_ids is None else env_ids] = 0.0

    def _limits(self) -> tuple[torch.Tensor, torch.Tensor]:
        limits = columns(self._asset.data.soft_joint_pos_limits, self._joint_ids)
        return limits[..., 0], limits[..., 1]


class EMAJointPositionToLimitsAction(JointPositionToLimitsAction):
    """Its targets are an exponential moving average: ``alpha * new + (1 - alpha) * previous target``.

    The average starts at the joint positions that the reset left.
    """

    cfg: actions_cfg.EMAJointPositionToLimitsActionCfg

    def __init__(self, cfg: actions_cfg.EMAJointPositionToLimitsActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        self._alpha = values_of_names(cfg.alpha, self._joint_names, 1.0, self.num_envs, self.device)
        weights = torch.as_tensor(self._alpha)
        if bool(((weights < 0.0) | (weights > 1.0)).any()):
            raise ConfigError(f"the moving average's weight alpha must be within [0, 1], got {cfg.alpha}")
        self._previous = torch.zeros_like(self._processed_actions)

    @property
    def IO_descriptor(self) -> GenericActionIODescriptor:
        """Adds ``alpha``, the weight of a new target."""
        descriptor = super().IO_descriptor
        descriptor.alpha = first_row(self._alpha)
        return descriptor

    def process_actions(self, actions: torch.Tensor) -> None:
        """Compute the position targets."""
        super().process_actions(actions)
        average = self._previous + self._alpha * (self._processed_actions - self._previous)
        self._processed_actions = average.clamp(*self._limits())
        self._previous[:] = self._processed_actions

    def reset(self, env_ids: EnvIds = None) -> None:
        """Start the average of some environments at the current joint positions."""
        super().reset(env_ids)
        rows = slice(None) if env_ids is None else env_ids
        self._previous[rows] = columns(self._asset.data.joint_pos, self._joint_ids)[rows]
