"""Contact sensor: config only."""

from __future__ import annotations

from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError

from ..sensor_base import SensorBase
from ..sensor_base_cfg import SensorBaseCfg


class ContactSensor(SensorBase):
    """A type for configs; making one raises."""

    def __init__(self, cfg: SensorBaseCfg):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"'{cfg.prim_path}': contact sensors are not simulated; remove ContactSensorCfg")

    @property
    def data(self) -> None:
        """There is none."""


@configclass
class ContactSensorCfg(SensorBaseCfg):
    """A contact sensor: accepted as data; building a scene with one raises."""

    class_type: type = ContactSensor
    track_pose: bool = False
    track_contact_points: bool = False
    track_friction_forces: bool = False
    max_contact_data_count_per_prim: int = 4
    track_air_time: bool = False
    force_threshold: float = 1.0
    filter_prim_paths_expr: list[str] = []


__all__ = ["ContactSensor", "ContactSensorCfg"]
