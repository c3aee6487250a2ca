"""Isaac Lab's module path of the actuator configs."""

from .actuator_cfg import ActuatorBaseCfg, DCMotorCfg, IdealPDActuatorCfg, ImplicitActuatorCfg

__all__ = ["ActuatorBaseCfg", "DCMotorCfg", "IdealPDActuatorCfg", "ImplicitActuatorCfg"]
