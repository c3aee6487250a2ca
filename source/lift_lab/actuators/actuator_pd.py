"""PD actuator models."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import MISSING
from typing import TYPE_CHECKING, Any

import torch

from lift_lab.utils.buffers import DelayBuffer
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.interpolation import LinearInterpolation
from lift_lab.utils.types import ArticulationActions

from .actuator_base import ActuatorBase

if TYPE_CHECKING:
    from .actuator_cfg import (
        DCMotorCfg,
        DelayedPDActuatorCfg,
        ImplicitActuatorCfg,
        RemotizedPDActuatorCfg,
    )


def _as_effort(action: ArticulationActions, effort: torch.Tensor) -> ArticulationActions:
    """The action with an effort in place of its targets, changed in place as Isaac Lab does."""
    action.joint_efforts, action.joint_positions, action.joint_velocities = effort, None, None
    return action


def _targets(action: ArticulationActions) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    position, velocity, effort = action.joint_positions, action.joint_velocities, action.joint_efforts
    assert position is not None
    assert velocity is not None
    assert effort is not None
    return position, velocity, effort


class ImplicitActuator(ActuatorBase):
    """The engine's own PD drive: tau = kp (q* - q) + kd (qd* - qd) + tau_ff, clipped at the effort limit.

    :meth:`compute` notes the law's value and hands the targets on to the engine. Where a sub-class overrides it, it is
    called before each physics step, and the engine follows the targets that it returns.
    """

    cfg: ImplicitActuatorCfg
    is_implicit_model = True

    def __init__(self, cfg: ImplicitActuatorCfg, *args: Any, **kwargs: Any):
        """See :class:`ActuatorBase`. As in Isaac Lab, both effort limits of ``cfg`` become the one that is given;
        a velocity limit counts only as ``velocity_limit_sim``.

        Raises:
            ConfigError: ``effort_limit`` and ``effort_limit_sim``, or the velocity limits, are both given and differ.
        """
        _merge_limits(cfg, "effort_limit")
        if cfg.velocity_limit_sim is None:
            cfg.velocity_limit = None
        _merge_limits(cfg, "velocity_limit")
        super().__init__(cfg, *args, **kwargs)

    @property
    def runs_in_engine(self) -> bool:
        """Whether :meth:`compute` is this class's own."""
        return type(self).compute is ImplicitActuator.compute

    def compute(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> ArticulationActions:
        """See :meth:`ActuatorBase.compute`; returns the targets as they are given."""
        self.computed_effort = self._pd_effort(control_action, joint_pos, joint_vel)
        self.applied_effort = self._clip_effort(self.computed_effort)
        return control_action


def _merge_limits(cfg: ImplicitActuatorCfg, name: str) -> None:
    """Give an implicit model's two limits of one kind the value of the one that is set."""
    model, engine = getattr(cfg, name), getattr(cfg, f"{name}_sim")
    if model is not None and engine is not None and model != engine:
        raise ConfigError(
            f"{type(cfg).__name__}: {name} {model} and {name}_sim {engine} differ, and an implicit actuator has one"
            f" limit; set only {name}_sim"
        )
    setattr(cfg, name, engine if model is None else model)
    setattr(cfg, f"{name}_sim", model if engine is None else engine)


class IdealPDActuator(ActuatorBase):
    """tau = kp (q* - q) + kd (qd* - qd) + tau_ff, clipped: computed in torch before each physics step."""

    def compute(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> ArticulationActions:
        """See :meth:`ActuatorBase.compute`."""
        self.computed_effort = self._pd_effort(control_action, joint_pos, joint_vel)
        self.applied_effort = self._clip_effort(self.computed_effort)
        return _as_effort(control_action, self.applied_effort)


class DCMotor(IdealPDActuator):
    """An ideal PD controller behind a DC motor's torque-speed line.

    The effort at velocity qd lies between ``saturation_effort * (-1 - qd / velocity_limit)`` and
    ``saturation_effort * (1 - qd / velocity_limit)``, and within the effort limit. A joint that something else drives
    faster than the no-load speed is braked, by the effort limit at most.
    """

    def __init__(self, cfg: DCMotorCfg, *args: Any, **kwargs: Any):
        """See :class:`ActuatorBase`.

        Raises:
            ConfigError: no saturation effort, or a velocity limit neither in the config nor in the file.
        """
        super().__init__(cfg, *args, **kwargs)
        if cfg.saturation_effort is None or cfg.saturation_effort is MISSING:
            raise ConfigError(f"{type(cfg).__name__}: saturation_effort must be given")
        if bool(torch.isinf(self.velocity_limit).any()):
            raise ConfigError(f"{type(cfg).__name__}: velocity_limit, the no-load speed, must be given")
        self._saturation_effort = cfg.saturation_effort
        self._vel_at_effort_lim = self.velocity_limit * (1 + self.effort_limit / self._saturation_effort)
        self._joint_vel = torch.zeros_like(self.computed_effort)
        self._zeros_effort = torch.zeros_like(self.computed_effort)

    def compute(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> ArticulationActions:
        """See :meth:`ActuatorBase.compute`."""
        self._joint_vel[:] = joint_vel
        return super().compute(control_action, joint_pos, joint_vel)

    def _clip_effort(self, effort: torch.Tensor) -> torch.Tensor:
        stall = self._saturation_effort
        ratio = self._joint_vel / self.velocity_limit
        limit = self.effort_limit
        highest = torch.clamp(stall * (1.0 - ratio), -limit, limit)
        lowest = torch.clamp(stall * (-1.0 - ratio), -limit, limit)
        return torch.clamp(effort, lowest, highest)


class DelayedPDActuator(IdealPDActuator):
    """An ideal PD controller whose targets arrive some physics steps late.

    Each reset draws the lag of its environments from the config's ``min_delay`` to ``max_delay``; until the first
    reset there is none. Until the first target of an episode arrives, the drive is given those that the reset left.
    """

    def __init__(self, cfg: DelayedPDActuatorCfg, *args: Any, **kwargs: Any):
        """See :class:`ActuatorBase`.

        Raises:
            ConfigError: the delays are no range.
        """
        super().__init__(cfg, *args, **kwargs)
        if not 0 <= cfg.min_delay <= cfg.max_delay:
            raise ConfigError(
                f"{type(cfg).__name__}: min_delay must lie between 0 and max_delay {cfg.max_delay}, got {cfg.min_delay}"
            )
        self.positions_delay_buffer = DelayBuffer(cfg.max_delay, self._num_envs, self._device)
        self.velocities_delay_buffer = DelayBuffer(cfg.max_delay, self._num_envs, self._device)
        self.efforts_delay_buffer = DelayBuffer(cfg.max_delay, self._num_envs, self._device)

    @property
    def _buffers(self) -> tuple[DelayBuffer, DelayBuffer, DelayBuffer]:
        return self.positions_delay_buffer, self.velocities_delay_buffer, self.efforts_delay_buffer

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None) -> None:
        """Clear the targets of some environments and draw new lags."""
        super().reset(env_ids)
        ids = torch.arange(self._num_envs, device=self._device)[slice(None) if env_ids is None else env_ids]
        lags = torch.randint(self.cfg.min_delay, self.cfg.max_delay + 1, (len(ids),), device=self._device)
        for buffer in self._buffers:
            buffer.set_time_lag(lags, ids)
            buffer.reset(ids)

    def start_episodes(self, env_ids: torch.Tensor, control_action: ArticulationActions) -> None:
        """See :meth:`ActuatorBase.start_episodes`."""
        for buffer, target in zip(self._buffers, _targets(control_action), strict=True):
            buffer.fill(target, env_ids)

    def compute(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> ArticulationActions:
        """See :meth:`ActuatorBase.compute`."""
        position, velocity, effort = _targets(control_action)
        control_action.joint_positions = self.positions_delay_buffer.compute(position)
        control_action.joint_velocities = self.velocities_delay_buffer.compute(velocity)
        control_action.joint_efforts = self.efforts_delay_buffer.compute(effort)
        return super().compute(control_action, joint_pos, joint_vel)


class RemotizedPDActuator(DelayedPDActuator):
    """A delayed PD controller whose effort limit depends on the joint's angle, by a table.

    The config's own effort and velocity limits do not apply.
    """

    cfg: RemotizedPDActuatorCfg

    def __init__(self, cfg: RemotizedPDActuatorCfg, *args: Any, **kwargs: Any):
        """See :class:`ActuatorBase`."""
        super().__init__(cfg, *args, **kwargs)
        self.effort_limit.fill_(torch.inf)
        self.velocity_limit.fill_(torch.inf)
        self._lookup = torch.tensor(cfg.joint_parameter_lookup, dtype=torch.float32, device=self._device)
        self._torque_limit = LinearInterpolation(self.angle_samples, self.max_torque_samples, self._device)

    @property
    def angle_samples(self) -> torch.Tensor:
        """Angles of the table in rad, shape (num_samples,)."""
        return self._lookup[:, 0]

    @property
    def transmission_ratio_samples(self) -> torch.Tensor:
        """Transmission ratios of the table, shape (num_samples,)."""
        return self._lookup[:, 1]

    @property
    def max_torque_samples(self) -> torch.Tensor:
        """Effort limits of the table in N m, shape (num_samples,)."""
        return self._lookup[:, 2]

    def compute(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> ArticulationActions:
        """See :meth:`ActuatorBase.compute`."""
        action = super().compute(control_action, joint_pos, joint_vel)
        limit = self._torque_limit.compute(joint_pos)
        self.applied_effort = torch.clamp(self.applied_effort, -limit, limit)
        action.joint_efforts = self.applied_effort
        return action
