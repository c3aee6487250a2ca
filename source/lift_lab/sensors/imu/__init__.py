"""Inertial measurement unit."""

from .imu import Imu
from .imu_cfg import ImuCfg
from .imu_data import ImuData

__all__ = ["Imu", "ImuCfg", "ImuData"]
