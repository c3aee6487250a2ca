"""Config that all sensors share."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import COUNT_OR_ZERO, NOT_NEGATIVE, Ranges

from .sensor_base import SensorBase

__all__ = [
    "SensorBaseCfg",
]


@configclass
class SensorBaseCfg(ConfigBase):
    """A sensor of the scene."""

    class_type: type[SensorBase] = MISSING
    prim_path: str = MISSING
    """Isaac Lab's prim path of the body to which the sensor is attached."""
    update_period: float = 0.0
    """Least time between two readings of a contact sensor in s, 0 reads after each physics step.
    Other sensors always give the current value."""
    history_length: int = 0
    """Number of past readings kept."""
    debug_vis: bool = False
    """Whether the sensor's markers are drawn where a viewer shows markers."""

    _ranges: ClassVar[Ranges] = {"update_period": NOT_NEGATIVE, "history_length": COUNT_OR_ZERO}
