"""Config of an articulation."""

from __future__ import annotations

from typing import ClassVar, Literal

from lift_lab.actuators import ActuatorBaseCfg
from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import FINITE, POSITIVE, Ranges

from ..asset_base_cfg import AssetBaseCfg
from .articulation import Articulation


@configclass
class ArticulationCfg(AssetBaseCfg):
    """A robot or another mechanism."""

    @configclass
    class InitialStateCfg(AssetBaseCfg.InitialStateCfg):
        """Pose, velocity and joint state at start, in the environment's frame."""

        lin_vel: tuple[float, float, float] = (0.0, 0.0, 0.0)
        """Linear velocity of the root in m/s."""
        ang_vel: tuple[float, float, float] = (0.0, 0.0, 0.0)
        """Angular velocity of the root in rad/s."""
        joint_pos: dict[str, float] = {".*": 0.0}
        """Joint name pattern -> position in rad or m."""
        joint_vel: dict[str, float] = {".*": 0.0}
        """Joint name pattern -> velocity in rad/s or m/s."""

        _ranges: ClassVar[Ranges] = {"lin_vel ang_vel joint_pos joint_vel": FINITE}

    class_type: type = Articulation
    articulation_root_prim_path: str | None = None
    """Isaac Lab's path of the root prim below the asset. The importer finds the root itself."""
    init_state: InitialStateCfg = InitialStateCfg()
    """Initial pose, velocities and joint state, also the default state of resets."""
    soft_joint_pos_limit_factor: float = 1.0
    """Soft position limits as a fraction of the joint's range about its middle."""
    index_order: Literal["breadth_first", "engine"] = "breadth_first"
    """Order of joints and bodies in names, data, actions and indices.

    ``"breadth_first"`` is Isaac Lab's: all joints of a level of the tree, then those of the next. ``"engine"`` is
    MuJoCo's: each limb to its end, then the next. A serial arm has the same order in both.
    """
    actuators: dict[str, ActuatorBaseCfg] = MISSING
    """Group name -> actuator model of the joints it names."""
    actuator_value_resolution_debug_print: bool = False
    """Whether values that come from the USD file are logged."""

    _ranges: ClassVar[Ranges] = {"soft_joint_pos_limit_factor": POSITIVE}
