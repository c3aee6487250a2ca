"""Actuator models learned from a real drive: TorchScript networks from joint history to effort."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import torch

from lift_lab.utils.assets import read_file
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.types import ArticulationActions

from .actuator_pd import DCMotor

if TYPE_CHECKING:
    from .actuator_cfg import ActuatorNetLSTMCfg, ActuatorNetMLPCfg


class _ActuatorNet(DCMotor):
    """Only position targets enter the network; its effort is clipped as a DC motor's."""

    def __init__(self, cfg: ActuatorNetLSTMCfg | ActuatorNetMLPCfg, *args: Any, **kwargs: Any):
        """Load the network (see :class:`ActuatorBase`).

        Raises:
            FileError: the network's file does not exist.
        """
        super().__init__(cfg, *args, **kwargs)
        self.network = torch.jit.load(read_file(cfg.network_file), map_location=self._device).eval()

    def compute(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> ArticulationActions:
        """See :meth:`ActuatorBase.compute`."""
        target = control_action.joint_positions
        assert target is not None
        self._joint_vel[:] = joint_vel
        with torch.no_grad():
            self.computed_effort = self._effort(target - joint_pos, joint_vel)
        self.applied_effort = self._clip_effort(self.computed_effort)
        control_action.joint_efforts = self.applied_effort
        control_action.joint_positions = control_action.joint_velocities = None
        return control_action

    @abstractmethod
    def _effort(self, pos_error: torch.Tensor, joint_vel: torch.Tensor) -> torch.Tensor:
        """The network's answer, shape (num_envs, num_joints)."""


class ActuatorNetMLP(_ActuatorNet):
    """A feed-forward network of position errors and velocities now and some physics steps ago.

    J. Hwangbo et al., "Learning agile and dynamic motor skills for legged robots", Science Robotics 4 (2019).
    """

    cfg: ActuatorNetMLPCfg

    def __init__(self, cfg: ActuatorNetMLPCfg, *args: Any, **kwargs: Any):
        """See :class:`ActuatorBase`.

        Raises:
            ConfigError: an input order that does not exist.
        """
        super().__init__(cfg, *args, **kwargs)
        if cfg.input_order not in ("pos_vel", "vel_pos"):
            raise ConfigError(f"ActuatorNetMLPCfg: input_order must be pos_vel or vel_pos, not '{cfg.input_order}'")
        self._steps = list(cfg.input_idx)
        shape = (max(self._steps) + 1, self._num_envs, self.num_joints)
        self._pos_error_history = torch.zeros(shape, device=self._device)  # newest first
        self._vel_history = torch.zeros(shape, device=self._device)

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None) -> None:
        """Forget the history of some environments."""
        ids = slice(None) if env_ids is None else env_ids
        self._pos_error_history[:, ids] = 0.0
        self._vel_history[:, ids] = 0.0

    def _effort(self, pos_error: torch.Tensor, joint_vel: torch.Tensor) -> torch.Tensor:
        self._pos_error_history = self._pos_error_history.roll(1, dims=0)
        self._vel_history = self._vel_history.roll(1, dims=0)
        self._pos_error_history[0], self._vel_history[0] = pos_error, joint_vel
        inputs = [
            self.cfg.pos_scale * self._pos_error_history[self._steps],
            self.cfg.vel_scale * self._vel_history[self._steps],
        ]
        if self.cfg.input_order == "vel_pos":
            inputs.reverse()
        rows = torch.cat(inputs).permute(1, 2, 0).reshape(self._num_envs * self.num_joints, -1)
        return self.cfg.torque_scale * self.network(rows).view(self._num_envs, self.num_joints)


class ActuatorNetLSTM(_ActuatorNet):
    """A recurrent network of position error and velocity, its state kept for each joint.

    N. Rudin et al., "Learning to walk in minutes using massively parallel deep reinforcement learning", CoRL (2021).
    The network has a part ``lstm`` and takes and gives back its (hidden, cell) state.
    """

    cfg: ActuatorNetLSTMCfg

    def __init__(self, cfg: ActuatorNetLSTMCfg, *args: Any, **kwargs: Any):
        """See :class:`ActuatorBase`."""
        super().__init__(cfg, *args, **kwargs)
        weights = self.network.lstm.state_dict()
        num_layers = sum(name.startswith("weight_hh") for name in weights)
        size = weights["weight_hh_l0"].shape[1]
        shape = (num_layers, self._num_envs, self.num_joints, size)
        self._hidden = torch.zeros(shape, device=self._device)
        self._cell = torch.zeros(shape, device=self._device)

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None) -> None:
        """Forget the network's state of some environments."""
        ids = slice(None) if env_ids is None else env_ids
        self._hidden[:, ids] = 0.0
        self._cell[:, ids] = 0.0

    def _effort(self, pos_error: torch.Tensor, joint_vel: torch.Tensor) -> torch.Tensor:
        inputs = torch.stack((pos_error.flatten(), joint_vel.flatten()), dim=-1).unsqueeze(1)
        state = self._hidden.flatten(1, 2), self._cell.flatten(1, 2)
        effort, (hidden, cell) = self.network(inputs, state)
        self._hidden = hidden.reshape(self._hidden.shape).clone()
        self._cell = cell.reshape(self._cell.shape).clone()
        return effort.reshape(self._num_envs, self.num_joints)
