"""Terminations of the lift task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.ranges import POSITIVE

from .metrics import object_goal_distance_m

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


def object_reached_goal(
    env: ManagerBasedRLEnv,
    command_name: str = "object_pose",
    threshold: Annotated[float, POSITIVE] = 0.02,
    robot_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
    object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
) -> torch.Tensor:
    """Whether the object is within ``threshold`` (m) of its goal (the paper's Eq. (7)). Shape (num_envs,)."""
    return object_goal_distance_m(env, command_name, robot_cfg.name, object_cfg.name) < threshold
