"""Actuator models: how joint targets become joint torques."""

from .actuator_base import ActuatorBase
from .actuator_cfg import ActuatorBaseCfg, DCMotorCfg, IdealPDActuatorCfg, ImplicitActuatorCfg
from .actuator_pd import DCMotor, IdealPDActuator, ImplicitActuator

__all__ = [
    "ActuatorBase",
    "ActuatorBaseCfg",
    "DCMotor",
    "DCMotorCfg",
    "IdealPDActuator",
    "IdealPDActuatorCfg",
    "ImplicitActuator",
    "ImplicitActuatorCfg",
]
