"""Config of a rigid object."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, Ranges

from ..asset_base_cfg import AssetBaseCfg
from .rigid_object import RigidObject


@configclass
class RigidObjectCfg(AssetBaseCfg):
    """A single rigid body."""

    @configclass
    class InitialStateCfg(AssetBaseCfg.InitialStateCfg):
        """Pose and velocity at start, in the environment's frame."""

        lin_vel: tuple[float, float, float] = (0.0, 0.0, 0.0)
        """Linear velocity in m/s."""
        ang_vel: tuple[float, float, float] = (0.0, 0.0, 0.0)
        """Angular velocity in rad/s."""

        _ranges: ClassVar[Ranges] = {"lin_vel ang_vel": FINITE}

    class_type: type = RigidObject
    init_state: InitialStateCfg = InitialStateCfg()
    """Initial pose and velocities, also the default state of resets."""
