"""Config of a surface gripper (data only)."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import NOT_NEGATIVE_OR_INF, Ranges

from ..asset_base_cfg import AssetBaseCfg
from .surface_gripper import SurfaceGripper


@configclass
class SurfaceGripperCfg(AssetBaseCfg):
    """Surface gripper: accepted as data; building a scene with one raises."""

    class_type: type = SurfaceGripper
    max_grip_distance: float | None = None
    coaxial_force_limit: float | None = None
    shear_force_limit: float | None = None
    retry_interval: float | None = None

    _ranges: ClassVar[Ranges] = {
        "max_grip_distance coaxial_force_limit shear_force_limit retry_interval": NOT_NEGATIVE_OR_INF,
    }
