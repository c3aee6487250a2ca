"""Config of a scene."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import COUNT, NOT_NEGATIVE, Ranges


@configclass
class InteractiveSceneCfg(ConfigBase):
    """A scene. Subclasses add assets, sensors, lights and terrain as fields; the field's name is the entity's."""

    num_envs: int = MISSING
    """Number of environments."""
    env_spacing: float = MISSING
    """Distance between environment origins in m."""
    lazy_sensor_update: bool = True
    """Isaac Lab's switch. Sensors here always compute on demand."""
    replicate_physics: bool = True
    """Isaac Lab's cloning switch. All environments share one model here."""
    filter_collisions: bool = True
    """Isaac Lab's switch. Environments never collide with each other here."""
    clone_in_fabric: bool = False
    """Omniverse's cloning switch."""

    _ranges: ClassVar[Ranges] = {"num_envs": COUNT, "env_spacing": NOT_NEGATIVE}
