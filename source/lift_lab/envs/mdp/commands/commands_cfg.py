"""Configs of the command terms, with Isaac Lab's names."""

from __future__ import annotations

import math
from typing import ClassVar

from lift_lab.managers import CommandTermCfg
from lift_lab.markers import VisualizationMarkersCfg
from lift_lab.markers.config import BLUE_ARROW_X_MARKER_CFG, FRAME_MARKER_CFG, GREEN_ARROW_X_MARKER_CFG
from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import FINITE, FRACTION, NOT_NEGATIVE, SPAN
from lift_lab.utils.ranges import Ranges as NumberRanges

from .null_command import NullCommand
from .pose_2d_command import TerrainBasedPose2dCommand, UniformPose2dCommand
from .pose_command import UniformPoseCommand
from .velocity_command import NormalVelocityCommand, UniformVelocityCommand

__all__ = [
    "NormalVelocityCommandCfg",
    "NullCommandCfg",
    "TerrainBasedPose2dCommandCfg",
    "UniformPose2dCommandCfg",
    "UniformPoseCommandCfg",
    "UniformVelocityCommandCfg",
]


def _marker(
    cfg: VisualizationMarkersCfg, name: str, prim_path: str, scale: tuple[float, float, float]
) -> VisualizationMarkersCfg:
    cfg = cfg.replace(prim_path=prim_path)
    cfg.markers[name].scale = scale
    return cfg


@configclass
class NullCommandCfg(CommandTermCfg):
    """Config of :class:`NullCommand`."""

    class_type: type = NullCommand

    resampling_time_range: tuple[float, float] = (math.inf, math.inf)
    """Nothing is ever drawn."""


@configclass
class UniformPoseCommandCfg(CommandTermCfg):
    """Config of :class:`UniformPoseCommand`."""

    class_type: type = UniformPoseCommand

    asset_name: str = MISSING
    """The articulation in whose root frame poses are drawn."""

    body_name: str = MISSING
    """The body whose distance to the commanded pose is logged."""

    make_quat_unique: bool = False
    """Whether q is turned into -q where its real part is negative."""

    @configclass
    class Ranges:
        """(low, high) of the pose in the root frame."""

        pos_x: tuple[float, float] = MISSING
        """x in m."""
        pos_y: tuple[float, float] = MISSING
        """y in m."""
        pos_z: tuple[float, float] = MISSING
        """z in m."""
        roll: tuple[float, float] = MISSING
        """Roll in rad."""
        pitch: tuple[float, float] = MISSING
        """Pitch in rad."""
        yaw: tuple[float, float] = MISSING
        """Yaw in rad."""

        _ranges: ClassVar[NumberRanges] = {"pos_x pos_y pos_z roll pitch yaw": SPAN}

    ranges: Ranges = MISSING
    """Ranges of the poses."""

    goal_pose_visualizer_cfg: VisualizationMarkersCfg = _marker(
        FRAME_MARKER_CFG, "frame", "/Visuals/Command/goal_pose", (0.1, 0.1, 0.1)
    )
    """Marker of the commanded pose."""

    current_pose_visualizer_cfg: VisualizationMarkersCfg = _marker(
        FRAME_MARKER_CFG, "frame", "/Visuals/Command/body_pose", (0.1, 0.1, 0.1)
    )
    """Marker of the body's pose."""


@configclass
class UniformVelocityCommandCfg(CommandTermCfg):
    """Config of :class:`UniformVelocityCommand`."""

    class_type: type = UniformVelocityCommand

    asset_name: str = MISSING
    """The asset that is to follow the command."""

    heading_command: bool = False
    """Whether the yaw rate steers towards a drawn heading, or is drawn itself."""

    heading_control_stiffness: float = 1.0
    """Yaw rate for each rad of heading error in 1/s."""

    rel_standing_envs: float = 0.0
    """Probability that a command is to stand still."""

    rel_heading_envs: float = 1.0
    """Probability that a command steers towards a heading, given :attr:`heading_command`."""

    @configclass
    class Ranges:
        """(low, high) of the velocity in the root frame."""

        lin_vel_x: tuple[float, float] = MISSING
        """Forward velocity in m/s."""
        lin_vel_y: tuple[float, float] = MISSING
        """Sideways velocity in m/s."""
        ang_vel_z: tuple[float, float] = MISSING
        """Yaw rate in rad/s."""
        heading: tuple[float, float] | None = None
        """Heading in the world frame in rad."""

        _ranges: ClassVar[NumberRanges] = {"lin_vel_x lin_vel_y ang_vel_z heading": SPAN}

    ranges: Ranges = MISSING
    """Ranges of the commands."""

    goal_vel_visualizer_cfg: VisualizationMarkersCfg = _marker(
        GREEN_ARROW_X_MARKER_CFG, "arrow", "/Visuals/Command/velocity_goal", (0.5, 0.5, 0.5)
    )
    """Marker of the commanded velocity."""

    current_vel_visualizer_cfg: VisualizationMarkersCfg = _marker(
        BLUE_ARROW_X_MARKER_CFG, "arrow", "/Visuals/Command/velocity_current", (0.5, 0.5, 0.5)
    )
    """Marker of the current velocity."""

    _ranges: ClassVar[NumberRanges] = {
        "heading_control_stiffness": FINITE,
        "rel_standing_envs rel_heading_envs": FRACTION,
    }


@configclass
class NormalVelocityCommandCfg(UniformVelocityCommandCfg):
    """Config of :class:`NormalVelocityCommand`."""

    class_type: type = NormalVelocityCommand

    @configclass
    class Ranges:  # pyright: ignore[reportIncompatibleVariableOverride]  # Isaac Lab's name
        """Normal distributions of forward velocity, sideways velocity (m/s) and yaw rate (rad/s)."""

        mean_vel: tuple[float, float, float] = MISSING
        """Means of their magnitudes."""
        std_vel: tuple[float, float, float] = MISSING
        """Standard deviations."""
        zero_prob: tuple[float, float, float] = MISSING
        """Probabilities of being zero."""

        _ranges: ClassVar[NumberRanges] = {"mean_vel": FINITE, "std_vel": NOT_NEGATIVE, "zero_prob": FRACTION}

    ranges: Ranges = MISSING  # pyright: ignore[reportIncompatibleVariableOverride]
    """Ranges of the commands."""


@configclass
class UniformPose2dCommandCfg(CommandTermCfg):
    """Config of :class:`UniformPose2dCommand`."""

    class_type: type = UniformPose2dCommand

    asset_name: str = MISSING
    """The asset that is to reach the pose."""

    simple_heading: bool = MISSING
    """Whether the heading points along the way to the position, or is drawn."""

    @configclass
    class Ranges:
        """(low, high) of the pose, relative to the environment's origin."""

        pos_x: tuple[float, float] = MISSING
        """x in m."""
        pos_y: tuple[float, float] = MISSING
        """y in m."""
        heading: tuple[float, float] = MISSING
        """Heading in rad; not used with :attr:`simple_heading`."""

        _ranges: ClassVar[NumberRanges] = {"pos_x pos_y heading": SPAN}

    ranges: Ranges = MISSING
    """Ranges of the poses."""

    goal_pose_visualizer_cfg: VisualizationMarkersCfg = _marker(
        GREEN_ARROW_X_MARKER_CFG, "arrow", "/Visuals/Command/pose_goal", (0.2, 0.2, 0.8)
    )
    """Marker of the commanded pose."""


@configclass
class TerrainBasedPose2dCommandCfg(UniformPose2dCommandCfg):
    """Config of a pose on a generated terrain (data only)."""

    class_type: type = TerrainBasedPose2dCommand

    @configclass
    class Ranges:  # pyright: ignore[reportIncompatibleVariableOverride]  # Isaac Lab's name
        """(low, high) of the heading."""

        heading: tuple[float, float] = MISSING
        """Heading in rad; not used with ``simple_heading``."""

        _ranges: ClassVar[NumberRanges] = {"heading": SPAN}

    ranges: Ranges = MISSING  # pyright: ignore[reportIncompatibleVariableOverride]
    """Range of the headings."""
