"""Joint action terms: an affine map of the action becomes a position, velocity or effort target."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.utils.indexing import columns, compact_index, fill_rows
from lift_lab.utils.io_descriptors import GenericActionIODescriptor, plain
from lift_lab.utils.string import resolve_matching_names_values

from .stored_action import StoredAction

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedEnv
    from lift_lab.utils.indexing import EnvIds

    from . import actions_cfg

__all__ = [
    "JointAction",
    "JointEffortAction",
    "JointPositionAction",
    "JointVelocityAction",
    "RelativeJointPositionAction",
]


def values_of_names(
    values: dict[str, float] | float, names: Sequence[str], default: float, num_envs: int, device: str
) -> torch.Tensor | float:
    """Return a number unchanged, and a dictionary of name patterns as a tensor of shape (num_envs, len(names))."""
    if not isinstance(values, dict):
        return float(values)
    ids, _, found = resolve_matching_names_values(values, names)
    result = torch.full((num_envs, len(names)), default, device=device)
    result[:, ids] = torch.tensor(found, dtype=result.dtype, device=device)
    return result


def clip_limits(
    clip: dict[str, tuple[float, float]] | None, names: Sequence[str], num_envs: int, device: str
) -> torch.Tensor | None:
    """Bounds for the named columns, shape (num_envs, len(names), 2); None where nothing is clipped."""
    if clip is None:
        return None
    ids, _, found = resolve_matching_names_values(clip, names)
    bounds = torch.tensor([[-torch.inf, torch.inf]], device=device).repeat(num_envs, len(names), 1)
    bounds[:, ids] = torch.tensor(found, dtype=bounds.dtype, device=device)
    return bounds


def clipped(values: torch.Tensor, limits: torch.Tensor | None) -> torch.Tensor:
    """``values`` within the bounds that :func:`clip_limits` gives."""
    return values if limits is None else values.clamp(limits[..., 0], limits[..., 1])


def first_row(values: torch.Tensor | float | None) -> Any:
    """Return the numbers of the first environment as a list; a single number or None is returned unchanged."""
    return plain(values[0]) if isinstance(values, torch.Tensor) else values


class JointAction(StoredAction):
    """Base of the joint actions: ``processed = clip(raw * scale + offset)``, one column for each joint.

    The joints are those that match the config's patterns, in the articulation's order unless ``preserve_order``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_joint_columns", "_joint_ids", "_joint_names", "_num_joints"}
    )

    _asset: Articulation
    _scale: torch.Tensor | float
    """Factor of the raw action: a number, or shape (num_envs, action_dim)."""
    _offset: torch.Tensor | float
    """What is added to it: a number, or shape (num_envs, action_dim)."""
    _clip: torch.Tensor | None
    """Bounds of the processed action, shape (num_envs, action_dim, 2); None where the config clips nothing."""
    _joint_ids: list[int] | slice
    """Indices of the joints in the articulation; a slice stands for all of them, never for some (as in Isaac Lab)."""

    def __init__(self, cfg: actions_cfg.JointActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        ids, self._joint_names = self._asset.find_joints(cfg.joint_names, preserve_order=cfg.preserve_order)
        self._num_joints = len(ids)
        self._joint_columns = compact_index(ids, self._asset.num_joints, self.device)
        self._joint_ids = slice(None) if ids == list(range(self._asset.num_joints)) else ids
        self._raw_actions = torch.zeros(self.num_envs, self.action_dim, device=self.device)
        self._processed_actions = torch.zeros_like(self._raw_actions)
        self._scale = values_of_names(cfg.scale, self._joint_names, 1.0, self.num_envs, self.device)
        self._offset = values_of_names(cfg.offset, self._joint_names, 0.0, self.num_envs, self.device)
        self._clip = clip_limits(cfg.clip, self._joint_names, self.num_envs, self.device)

    @property
    def action_dim(self) -> int:
        """Number of joints."""
        return self._num_joints

    @property
    def IO_descriptor(self) -> GenericActionIODescriptor:
        """Adds ``joint_names``, and ``scale``, ``offset`` and ``clip`` of the first environment."""
        descriptor = super().IO_descriptor
        descriptor.action_type, descriptor.joint_names = "JointAction", list(self._joint_names)
        descriptor.scale, descriptor.offset = first_row(self._scale), first_row(self._offset)
        descriptor.clip = first_row(self._clip)
        return descriptor

    def process_actions(self, actions: torch.Tensor) -> None:
        """Scale, offset and clip the action."""
        self._raw_actions.copy_(actions)
        self._processed_actions = clipped(self._raw_actions * self._scale + self._offset, self._clip)

    def reset(self, env_ids: EnvIds = None) -> None:
        """Forget the raw action of some environments."""
        fill_rows(self._raw_actions, env_ids, 0.0)


class JointPositionAction(JointAction):
    """The processed action is the joints' position target."""

    cfg: actions_cfg.JointPositionActionCfg

    constant_over_substeps = True

    def __init__(self, cfg: actions_cfg.JointPositionActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        if cfg.use_default_offset:
            self._offset = columns(self._asset.data.default_joint_pos, self._joint_columns).clone()

    def apply_actions(self) -> None:
        """Set the position targets."""
        self._asset.set_joint_position_target(self._processed_actions, joint_ids=self._joint_columns)


class RelativeJointPositionAction(JointAction):
    """The processed action is added to the joints' current positions, at every physics step."""

    cfg: actions_cfg.RelativeJointPositionActionCfg

    def __init__(self, cfg: actions_cfg.RelativeJointPositionActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        if cfg.use_zero_offset:
            self._offset = 0.0

    def apply_actions(self) -> None:
        """Set the position targets."""
        target = self._processed_actions + columns(self._asset.data.joint_pos, self._joint_columns)
        self._asset.set_joint_position_target(target, joint_ids=self._joint_columns)


class JointVelocityAction(JointAction):
    """The processed action is the joints' velocity target."""

    cfg: actions_cfg.JointVelocityActionCfg

    constant_over_substeps = True

    def __init__(self, cfg: actions_cfg.JointVelocityActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        if cfg.use_default_offset:
            self._offset = columns(self._asset.data.default_joint_vel, self._joint_columns).clone()

    def apply_actions(self) -> None:
        """Set the velocity targets."""
        self._asset.set_joint_velocity_target(self._processed_actions, joint_ids=self._joint_columns)


class JointEffortAction(JointAction):
    """The processed action is the joints' effort target."""

    cfg: actions_cfg.JointEffortActionCfg

    constant_over_substeps = True

    def apply_actions(self) -> None:
        """Set the effort targets."""
        self._asset.set_joint_effort_target(self._processed_actions, joint_ids=self._joint_columns)
