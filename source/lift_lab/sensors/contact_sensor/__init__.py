"""Contact sensor: forces, and times in contact and in the air."""

from .contact_sensor import ContactSensor
from .contact_sensor_cfg import ContactSensorCfg
from .contact_sensor_data import ContactSensorData

__all__ = ["ContactSensor", "ContactSensorCfg", "ContactSensorData"]
