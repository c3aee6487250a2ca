"""Isaac Lab's module path of these configs."""

from .actuator_cfg import (
    ActuatorNetLSTMCfg,
    ActuatorNetMLPCfg,
)

__all__ = [
    "ActuatorNetLSTMCfg",
    "ActuatorNetMLPCfg",
]
