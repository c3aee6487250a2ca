"""Sensors."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from .contact_sensor import *
from .frame_transformer import *
from .imu import *
from .sensor_base import *
from .sensor_base_cfg import *

if TYPE_CHECKING:
    from ..isaac.sensors import *
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
