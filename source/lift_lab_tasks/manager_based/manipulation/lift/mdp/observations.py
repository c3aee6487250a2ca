"""Observations of the lift task."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.io_descriptors import generic_io_descriptor
from lift_lab.utils.math import quat_apply_inverse
from lift_lab.utils.mirror import mirrors_as

if TYPE_CHECKING:
    from lift_lab.assets import RigidObject
    from lift_lab.envs import ManagerBasedRLEnv


@mirrors_as("vector")
@generic_io_descriptor(units="m", axes=["X", "Y", "Z"], observation_type="RootState")
def object_position_in_robot_root_frame(
    env: ManagerBasedRLEnv,
    robot_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
    object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
) -> torch.Tensor:
    """Position of the object in the robot's root frame in m, shape (num_envs, 3)."""
    robot: RigidObject = env.scene[robot_cfg.name]
    object: RigidObject = env.scene[object_cfg.name]
    offset_w = object.data.root_pos_w - robot.data.root_pos_w
    return offset_w if robot.data.root_is_aligned else quat_apply_inverse(robot.data.root_quat_w, offset_w)
