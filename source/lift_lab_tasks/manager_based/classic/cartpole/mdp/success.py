"""Success of the cart-pole task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.utils.math import wrap_to_pi
from lift_lab.utils.ranges import POSITIVE

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv


def pole_balanced(env: ManagerBasedRLEnv, max_angle_rad: Annotated[float, POSITIVE] = 0.2) -> torch.Tensor:
    """Whether time has run out with the pole within ``max_angle_rad`` of upright. Shape (num_envs,)."""
    robot: Articulation = env.scene["robot"]
    pole = robot.joint_names.index("cart_to_pole")
    upright = wrap_to_pi(robot.data.joint_pos[:, pole]).abs() < max_angle_rad
    return upright & (env.episode_length_buf >= env.max_episode_length)
