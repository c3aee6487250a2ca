"""Surface gripper: config only."""

from .surface_gripper import SurfaceGripper
from .surface_gripper_cfg import SurfaceGripperCfg

__all__ = ["SurfaceGripper", "SurfaceGripperCfg"]
