"""PD actuator models."""

from __future__ import annotations

import torch

from .actuator_base import ActuatorBase


class ImplicitActuator(ActuatorBase):
    """The engine's own PD drive: tau = kp (q* - q) + kd (qd* - qd) + tau_ff, clipped at the effort limit.

    :meth:`compute` gives the same law's value for data and rewards; it does not drive the joint.
    """

    is_implicit_model = True


class IdealPDActuator(ActuatorBase):
    """The same law computed in torch before each physics step and applied as an effort."""


class DCMotor(IdealPDActuator):
    """An ideal PD controller behind a DC motor's torque-speed line.

    The effort at velocity qd lies between ``saturation_effort * (-1 - qd / velocity_limit)`` and
    ``saturation_effort * (1 - qd / velocity_limit)``, and within the effort limit.
    """

    def _clip(self, effort: torch.Tensor, joint_vel: torch.Tensor) -> torch.Tensor:
        stall = self.cfg.saturation_effort
        ratio = joint_vel / self.velocity_limit
        highest = torch.minimum((stall * (1.0 - ratio)).clamp(min=0.0), self.effort_limit)
        lowest = torch.maximum((stall * (-1.0 - ratio)).clamp(max=0.0), -self.effort_limit)
        return torch.clamp(effort, lowest, highest)
