"""Rewards of the reach task: how far a body is from the commanded pose, which is in the asset's root frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.math import quat_apply, quat_error_magnitude, quat_mul
from lift_lab.utils.ranges import POSITIVE

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv


def position_command_error(env: ManagerBasedRLEnv, command_name: str, asset_cfg: SceneEntityCfg) -> torch.Tensor:
    """Distance (m) of the first chosen body to the commanded position. Shape (num_envs,)."""
    asset: Articulation = env.scene[asset_cfg.name]
    command_b = env.command_manager.get_command(command_name)
    goal_w = asset.data.root_pos_w + quat_apply(asset.data.root_quat_w, command_b[:, :3])
    return torch.linalg.vector_norm(asset.data.body_pos_w[:, _body(asset_cfg)] - goal_w, dim=1)


def position_command_error_tanh(
    env: ManagerBasedRLEnv, std: Annotated[float, POSITIVE], command_name: str, asset_cfg: SceneEntityCfg
) -> torch.Tensor:
    """1 - tanh(distance / ``std``) of the first chosen body to the commanded position, ``std`` in m."""
    return 1.0 - torch.tanh(position_command_error(env, command_name, asset_cfg) / std)


def orientation_command_error(env: ManagerBasedRLEnv, command_name: str, asset_cfg: SceneEntityCfg) -> torch.Tensor:
    """Angle (rad) of the shortest turn of the first chosen body to the commanded orientation. Shape (num_envs,)."""
    asset: Articulation = env.scene[asset_cfg.name]
    command_b = env.command_manager.get_command(command_name)
    goal_quat_w = quat_mul(asset.data.root_quat_w, command_b[:, 3:7])
    return quat_error_magnitude(asset.data.body_quat_w[:, _body(asset_cfg)], goal_quat_w)


def _body(asset_cfg: SceneEntityCfg) -> int:
    ids = asset_cfg.body_ids
    return 0 if isinstance(ids, slice) else ids[0]
