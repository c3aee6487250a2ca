"""Config of a contact sensor."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.markers import CONTACT_SENSOR_MARKER_CFG, VisualizationMarkersCfg
from lift_lab.utils import configclass
from lift_lab.utils.ranges import COUNT, NOT_NEGATIVE, Ranges

from ..sensor_base_cfg import SensorBaseCfg
from .contact_sensor import ContactSensor


@configclass
class ContactSensorCfg(SensorBaseCfg):
    """Contact forces on bodies (Isaac Lab's). The bodies are those that ``prim_path`` matches."""

    class_type: type = ContactSensor
    track_pose: bool = False
    """Whether the bodies' poses are read."""
    track_contact_points: bool = False
    """Whether mean contact positions are read; needs filters."""
    track_friction_forces: bool = False
    """Whether tangential forces are read; needs filters."""
    max_contact_data_count_per_prim: int = 4
    """Least number of separate contacts between a body and a filter. There are always eight for each of a body's
    colliders, and twice that in the net force. If there are more contacts, or more than 64, the strongest count, and a
    warning is logged once."""
    track_air_time: bool = False
    """Whether times in the air and in contact are kept."""
    force_threshold: float = 1.0
    """Net force in N above which a body is in contact, for the times."""
    filter_prim_paths_expr: list[str] = []
    """Prim paths of what contacts are reported with one by one: bodies, or static assets and terrain."""
    visualizer_cfg: VisualizationMarkersCfg = CONTACT_SENSOR_MARKER_CFG.replace(prim_path="/Visuals/ContactSensor")
    """Markers of the contacts."""

    _ranges: ClassVar[Ranges] = {"max_contact_data_count_per_prim": COUNT, "force_threshold": NOT_NEGATIVE}
