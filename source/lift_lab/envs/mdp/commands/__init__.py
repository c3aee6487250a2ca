"""Command terms: goals that are drawn anew from time to time."""

from .commands_cfg import (
    NormalVelocityCommandCfg,
    NullCommandCfg,
    TerrainBasedPose2dCommandCfg,
    UniformPose2dCommandCfg,
    UniformPoseCommandCfg,
    UniformVelocityCommandCfg,
)
from .null_command import NullCommand
from .pose_2d_command import TerrainBasedPose2dCommand, UniformPose2dCommand
from .pose_command import UniformPoseCommand
from .velocity_command import NormalVelocityCommand, UniformVelocityCommand
