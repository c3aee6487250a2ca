"""Binary joint actions: one number opens or closes a gripper."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import torch

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.indexing import compact_index, fill_rows
from lift_lab.utils.io_descriptors import GenericActionIODescriptor, plain
from lift_lab.utils.string import resolve_matching_names_values

from .joint_actions import clip_limits, clipped
from .stored_action import StoredAction

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedEnv
    from lift_lab.utils.indexing import EnvIds

    from . import actions_cfg

__all__ = [
    "AbsBinaryJointPositionAction",
    "BinaryJointAction",
    "BinaryJointPositionAction",
    "BinaryJointVelocityAction",
]


_LONG_AGO = 2**30


class BinaryJointAction(StoredAction):
    """Base of the binary actions: a negative (or False) action closes, any other opens.

    With a ``min_close_time_s`` the gripper opens only when it has been closing for that long.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_joint_ids", "_joint_names"})

    _asset: Articulation

    def __init__(
        self,
        cfg: actions_cfg.BinaryJointActionCfg | actions_cfg.AbsBinaryJointPositionActionCfg,
        env: ManagerBasedEnv,
    ):
        super().__init__(cfg, env)
        ids, self._joint_names = self._asset.find_joints(cfg.joint_names)
        self._joint_ids = compact_index(ids, self._asset.num_joints, self.device)
        self._raw_actions = torch.zeros(self.num_envs, 1, device=self.device)
        self._processed_actions = torch.zeros(self.num_envs, len(ids), device=self.device)
        self._open_command = self._command("open_command_expr", cfg.open_command_expr)
        self._close_command = self._command("close_command_expr", cfg.close_command_expr)
        self._clip = clip_limits(cfg.clip, self._joint_names, self.num_envs, self.device)
        self._min_close_steps: torch.Tensor | None = None  # None: nothing is held
        self.set_min_close_time(cfg.min_close_time_s)

    def set_min_close_time(self, seconds: float | torch.Tensor) -> None:
        """Keep the gripper closed for at least ``seconds`` (0: as the actions say) after each time it closes."""
        if not isinstance(seconds, torch.Tensor) and not 0.0 <= seconds < float("inf"):
            raise ConfigError(f"{type(self).__name__}: min_close_time_s is {seconds}; it must be at least 0")
        if isinstance(seconds, float | int) and seconds == 0:
            self._min_close_steps = None
            return
        if self._min_close_steps is None:
            self._was_closed = torch.zeros(self.num_envs, 1, dtype=torch.bool, device=self.device)
            self._steps_closing = torch.full((self.num_envs, 1), _LONG_AGO, device=self.device)
        self._min_close_steps = torch.round(torch.as_tensor(seconds, device=self.device) / self._env.step_dt)

    def _command(self, field: str, expressions: dict[str, float]) -> torch.Tensor:
        """Targets of all joints, shape (num_joints,)."""
        ids, names, values = resolve_matching_names_values(expressions, self._joint_names)
        missing = [name for name in self._joint_names if name not in names]
        if missing:
            raise ConfigError(f"{type(self).__name__}: {field} says nothing about {', '.join(missing)}")
        command = torch.zeros(len(self._joint_names), device=self.device)
        command[ids] = torch.tensor(values, dtype=command.dtype, device=self.device)
        return command

    @property
    def action_dim(self) -> int:
        """1."""
        return 1

    @property
    def IO_descriptor(self) -> GenericActionIODescriptor:
        """Adds ``joint_names``, and the two commands and when the gripper closes in ``extras``."""
        descriptor = super().IO_descriptor
        descriptor.action_type, descriptor.joint_names = "JointAction", list(self._joint_names)
        open_command, close_command = (
            clipped(command, None if self._clip is None else self._clip[0])
            for command in (self._open_command, self._close_command)
        )
        descriptor.extras |= {
            "open_command": plain(open_command),
            "close_command": plain(close_command),
            "closes_when": self._closes_when,
            "min_close_time_s": self.cfg.min_close_time_s,
        }
        return descriptor

    @property
    def _closes_when(self) -> str:
        return "action < 0"

    def process_actions(self, actions: torch.Tensor) -> None:
        """Choose the open or closed targets."""
        self._raw_actions.copy_(actions)
        is_closed = self._is_closed(actions)
        if self._min_close_steps is not None:
            is_closed = is_closed | (self._steps_closing < self._min_close_steps)
            self._steps_closing += 1
            self._steps_closing.masked_fill_(is_closed > self._was_closed, 1)  # of booleans, > is "and not"
            self._was_closed = is_closed
        self._processed_actions = torch.where(is_closed, self._close_command, self._open_command)
        self._processed_actions = clipped(self._processed_actions, self._clip)

    def _is_closed(self, actions: torch.Tensor) -> torch.Tensor:
        return ~actions if actions.dtype == torch.bool else actions < 0

    def reset(self, env_ids: EnvIds = None) -> None:
        """Forget the raw action of some environments, and when they closed."""
        fill_rows(self._raw_actions, env_ids, 0.0)
        if self._min_close_steps is not None:
            fill_rows(self._was_closed, env_ids, False)
            fill_rows(self._steps_closing, env_ids, _LONG_AGO)


class BinaryJointPositionAction(BinaryJointAction):
    """The chosen targets are joint positions."""

    constant_over_substeps = True

    def apply_actions(self) -> None:
        """Set the position targets."""
        self._asset.set_joint_position_target(self._processed_actions, joint_ids=self._joint_ids)


class BinaryJointVelocityAction(BinaryJointAction):
    """The chosen targets are joint velocities."""

    cfg: actions_cfg.BinaryJointVelocityActionCfg

    constant_over_substeps = True

    def apply_actions(self) -> None:
        """Set the velocity targets."""
        self._asset.set_joint_velocity_target(self._processed_actions, joint_ids=self._joint_ids)


class AbsBinaryJointPositionAction(BinaryJointPositionAction):
    """Opens where the action is above a threshold (or below it, with ``positive_threshold=False``)."""

    cfg: actions_cfg.AbsBinaryJointPositionActionCfg

    @property
    def _closes_when(self) -> str:
        return f"action {'<=' if self.cfg.positive_threshold else '>='} {self.cfg.threshold:g}"

    def _is_closed(self, actions: torch.Tensor) -> torch.Tensor:
        return ~(actions > self.cfg.threshold if self.cfg.positive_threshold else actions < self.cfg.threshold)
