"""Isaac Lab's module path of these configs."""

from .actuator_cfg import (
    ActuatorBaseCfg,
)

__all__ = [
    "ActuatorBaseCfg",
]
