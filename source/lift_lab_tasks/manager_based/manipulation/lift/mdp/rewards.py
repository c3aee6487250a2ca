"""Rewards of the lift task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.ranges import FINITE, POSITIVE

from .metrics import object_goal_distance_m

if TYPE_CHECKING:
    from lift_lab.assets import RigidObject
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.sensors import FrameTransformer


def object_is_lifted(
    env: ManagerBasedRLEnv,
    minimal_height: Annotated[float, FINITE],
    object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
) -> torch.Tensor:
    """1 where the object's centre is above ``minimal_height`` (m, world), else 0 (the paper's Eq. (2))."""
    object: RigidObject = env.scene[object_cfg.name]
    return (object.data.root_pos_w[:, 2] > minimal_height).float()


def object_ee_distance(
    env: ManagerBasedRLEnv,
    std: Annotated[float, POSITIVE],
    object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
    ee_frame_cfg: SceneEntityCfg = SceneEntityCfg("ee_frame"),
) -> torch.Tensor:
    """1 - tanh(distance from the end effector to the object / ``std``), ``std`` in m (Isaac Lab's reaching reward)."""
    object: RigidObject = env.scene[object_cfg.name]
    ee_frame: FrameTransformer = env.scene[ee_frame_cfg.name]
    distance = torch.linalg.vector_norm(object.data.root_pos_w - ee_frame.data.target_pos_w[:, 0], dim=1)
    return 1.0 - torch.tanh(distance / std)


def object_goal_distance(
    env: ManagerBasedRLEnv,
    std: Annotated[float, POSITIVE],
    minimal_height: Annotated[float | None, FINITE],
    command_name: str,
    robot_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
    object_cfg: SceneEntityCfg = SceneEntityCfg("object"),
) -> torch.Tensor:
    """1 - tanh(distance from the object to its goal / ``std``), ``std`` in m (the paper's Eqs. (3) and (4)).

    Zero where the object is not above ``minimal_height``, as in Isaac Lab; None takes the gate away, as the equations
    are printed.
    """
    reward = 1.0 - torch.tanh(object_goal_distance_m(env, command_name, robot_cfg.name, object_cfg.name) / std)
    if minimal_height is None:
        return reward
    object: RigidObject = env.scene[object_cfg.name]
    return reward * (object.data.root_pos_w[:, 2] > minimal_height)
