"""Success of the reach task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.utils.math import quat_error_magnitude
from lift_lab.utils.ranges import POSITIVE

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


def pose_reached(
    env: ManagerBasedRLEnv,
    command_name: str = "ee_pose",
    max_distance: Annotated[float, POSITIVE] = 0.02,
    max_angle_rad: Annotated[float, POSITIVE] = 0.2,
) -> torch.Tensor:
    """Whether the body is within ``max_distance`` (m) and ``max_angle_rad`` of its pose, shape (num_envs,)."""
    term = env.command_manager.get_term(command_name)
    data = term.robot.data
    goal_w = term.pose_command_w
    distance = torch.linalg.vector_norm(data.body_pos_w[:, term.body_idx] - goal_w[:, :3], dim=1)
    angle = quat_error_magnitude(data.body_quat_w[:, term.body_idx], goal_w[:, 3:])
    return (distance < max_distance) & (angle < max_angle_rad)
