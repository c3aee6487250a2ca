"""Config of an inertial measurement unit."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.markers import RED_ARROW_X_MARKER_CFG, VisualizationMarkersCfg
from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, Ranges

from ..sensor_base_cfg import SensorBaseCfg
from .imu import Imu


@configclass
class ImuCfg(SensorBaseCfg):
    """An accelerometer and a gyroscope on the body that ``prim_path`` names (Isaac Lab's)."""

    @configclass
    class OffsetCfg:
        """The sensor's frame relative to its body's."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        """Position in m."""
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
        """Orientation (w, x, y, z)."""

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = Imu
    offset: OffsetCfg = OffsetCfg()
    """Pose of the sensor in the frame of its body."""
    gravity_bias: tuple[float, float, float] = (0.0, 0.0, 9.81)
    """Added to the kinematic acceleration, in the world frame in m/s^2. Minus gravity, as by default, gives what an
    accelerometer reads; zero gives the acceleration itself."""
    visualizer_cfg: VisualizationMarkersCfg = RED_ARROW_X_MARKER_CFG.replace(prim_path="/Visuals/Imu")
    """Marker of the acceleration."""

    _ranges: ClassVar[Ranges] = {"gravity_bias": FINITE}
