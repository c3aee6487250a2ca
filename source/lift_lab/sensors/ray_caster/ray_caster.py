"""Ray caster: a type for configs."""

from __future__ import annotations

from lift_lab.utils.errors import ConfigError

from ..sensor_base import SensorBase
from ..sensor_base_cfg import SensorBaseCfg


class RayCaster(SensorBase):
    """A type for configs; making one raises."""

    def __init__(self, cfg: SensorBaseCfg):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"'{cfg.prim_path}': ray casters are not simulated; remove the sensor from the scene")

    @property
    def data(self) -> None:
        """There is none."""
