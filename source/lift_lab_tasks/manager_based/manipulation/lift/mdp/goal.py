"""Distance from the object to its commanded position."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.envs.mdp import UniformPoseCommand
from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.math import quat_apply

from .commands import ObjectPoseCommand

if TYPE_CHECKING:
    from lift_lab.assets import RigidObject
    from lift_lab.envs import ManagerBasedRLEnv


def object_goal_distance_m(
    env: ManagerBasedRLEnv,
    command_name: str,
    robot_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
    object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
) -> torch.Tensor:
    """Distance in m from the object to the command, which is in the robot's root frame. Shape (num_envs,)."""
    robot: RigidObject = env.scene[robot_cfg.name]
    object: RigidObject = env.scene[object_cfg.name]
    term = env.command_manager.get_term(command_name)
    if isinstance(term, UniformPoseCommand) and term.robot is robot and term.command is term.pose_command_b:
        if isinstance(term, ObjectPoseCommand) and term.object is object:
            return term.object_distance
        goal_w = term.goal_pos_w
    else:
        goal_w = robot.data.root_pos_w + quat_apply(robot.data.root_quat_w, term.command[:, :3])
    return torch.linalg.vector_norm(object.data.root_pos_w - goal_w, dim=1)
