"""Metrics of the lift task: how the object follows its command."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.envs.mdp import command_pos_w
from lift_lab.managers import ManagerTermBase, MetricsTermCfg, SceneEntityCfg
from lift_lab.utils.indexing import fill_rows
from lift_lab.utils.ranges import POSITIVE, SPAN
from lift_lab.utils.step_cache import once_a_step

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


@once_a_step
def object_goal_distance_m(env: ManagerBasedRLEnv, command_name: str, robot: str, object: str) -> torch.Tensor:
    """Distance in m from an object to a command in a robot's root frame, shape (num_envs,)."""
    goal_w = command_pos_w(env, command_name, robot)
    return torch.linalg.vector_norm(env.scene[object].data.root_pos_w - goal_w, dim=1)


def object_position_error(
    env: ManagerBasedRLEnv,
    command_name: str,
    robot_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
    object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
) -> torch.Tensor:
    """Distance in m from the object to the command, which is in the robot's root frame."""
    return object_goal_distance_m(env, command_name, robot_cfg.name, object_cfg.name)


def time_to_success_s(
    env: ManagerBasedRLEnv,
    command_name: str,
    threshold: Annotated[float, POSITIVE],
    robot_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
    object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
) -> torch.Tensor:
    """Time in s since the episode began where the object is within ``threshold`` (m) of its goal, else NaN."""
    distance = object_goal_distance_m(env, command_name, robot_cfg.name, object_cfg.name)
    return torch.where(distance < threshold, env.episode_length_buf * env.step_dt, torch.nan)


class first_pick_drop(ManagerTermBase):
    """1 where the object lies again after it was held up, else 0.

    Params:
        heights_m: an object above the second height (world) is held; below the first one after that, it was dropped.
        object_cfg: the object.
    """

    def __init__(self, cfg: MetricsTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._held = torch.zeros(env.num_envs, dtype=torch.bool, device=env.device)

    def reset(self, env_ids: torch.Tensor | Sequence[int] | slice | None = None) -> None:
        """Begin with an object that was not held yet."""
        fill_rows(self._held, env_ids, False)

    def __call__(
        self,
        env: ManagerBasedRLEnv,
        heights_m: Annotated[tuple[float, float], SPAN],
        object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
    ) -> torch.Tensor:
        low_m, high_m = heights_m
        height_m = env.scene[object_cfg.name].data.root_pos_w[:, 2]
        dropped = self._held & (height_m < low_m)
        self._held |= height_m > high_m
        return dropped
