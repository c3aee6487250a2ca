"""Rewards of the cabinet task: approach the handle, grasp it, open the drawer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.math import matrix_from_quat
from lift_lab.utils.ranges import FINITE

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv


def approach_ee_handle(env: ManagerBasedRLEnv, threshold: Annotated[float, FINITE]) -> torch.Tensor:
    """1 / (1 + d^2)^2 of the distance d (m) from tool centre to handle, twice that within ``threshold`` (m)."""
    distance = _tool_distance(env)
    reward = (1.0 + distance.square()).pow(-2)
    return torch.where(distance <= threshold, 2.0 * reward, reward)


def align_ee_handle(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Alignment of the hand for a grasp: half the sum of the signed squares of two cosines, in [-1, 1].

    The cosines are between the z axes (the direction of the hand) and between the x axes of tool centre and handle
    frame. Isaac Lab uses the negative x and y axes of the handle's frame, which its configuration turns in another way.
    """
    tool = matrix_from_quat(env.scene["ee_frame"].data.target_quat_w[:, 0])
    handle = matrix_from_quat(env.scene["cabinet_frame"].data.target_quat_w[:, 0])
    cosines = (tool * handle).sum(dim=1)[:, (0, 2)]
    return 0.5 * (cosines * cosines.abs()).sum(dim=1)


def align_grasp_around_handle(env: ManagerBasedRLEnv) -> torch.Tensor:
    """1 where the left fingertip is above the handle and the right one below it, else 0."""
    heights = _fingertip_heights(env)
    return ((heights[:, 0] > 0.0) & (heights[:, 1] < 0.0)).float()


def approach_gripper_handle(env: ManagerBasedRLEnv, offset: Annotated[float, FINITE] = 0.04) -> torch.Tensor:
    """Closeness of both fingertips to the handle's height: the sum of ``offset`` (m) minus each distance.

    Zero unless one is above the handle and one below, see :func:`align_grasp_around_handle`.
    """
    closeness = (offset - _fingertip_heights(env).abs()).sum(dim=1)
    return align_grasp_around_handle(env) * closeness


def grasp_handle(
    env: ManagerBasedRLEnv, threshold: Annotated[float, FINITE], open_joint_pos: float, asset_cfg: SceneEntityCfg
) -> torch.Tensor:
    """Closing of the fingers, while the tool centre is within ``threshold`` (m) of the handle.

    Args:
        env: the environment.
        threshold: distance to the handle in m.
        open_joint_pos: position (m) of an open finger's joint; a closed one's is zero.
        asset_cfg: the gripper's joints.
    """
    gripper: Articulation = env.scene[asset_cfg.name]
    closed = (open_joint_pos - gripper.data.joint_pos[:, asset_cfg.joint_ids]).sum(dim=1)
    return (_tool_distance(env) <= threshold) * closed


def open_drawer_bonus(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg) -> torch.Tensor:
    """Opening of the drawer in m, doubled with the fingers around the handle."""
    return (1.0 + align_grasp_around_handle(env)) * _drawer_pos(env, asset_cfg)


def multi_stage_open_drawer(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg) -> torch.Tensor:
    """0.5 from 1 cm on; and, with the fingers around the handle, 1 more from 20 cm and 1 more from 30 cm on."""
    drawer = _drawer_pos(env, asset_cfg)
    around = align_grasp_around_handle(env)
    return 0.5 * (drawer > 0.01) + around * (drawer > 0.2) + around * (drawer > 0.3)


def _tool_distance(env: ManagerBasedRLEnv) -> torch.Tensor:
    offset_w = env.scene["cabinet_frame"].data.target_pos_w[:, 0] - env.scene["ee_frame"].data.target_pos_w[:, 0]
    return torch.linalg.vector_norm(offset_w, dim=1)


def _fingertip_heights(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Heights (m) of the left and the right fingertip above the handle, shape (num_envs, 2)."""
    fingertips_w = env.scene["ee_frame"].data.target_pos_w[:, 1:3, 2]
    return fingertips_w - env.scene["cabinet_frame"].data.target_pos_w[:, :1, 2]


def _drawer_pos(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg) -> torch.Tensor:
    cabinet: Articulation = env.scene[asset_cfg.name]
    return cabinet.data.joint_pos[:, asset_cfg.joint_ids][:, 0]
