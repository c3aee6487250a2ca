"""Rewards of the cart-pole."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.math import wrap_to_pi
from lift_lab.utils.ranges import FINITE

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv


def joint_pos_target_l2(
    env: ManagerBasedRLEnv, target: Annotated[float, FINITE], asset_cfg: SceneEntityCfg
) -> torch.Tensor:
    """Squared differences (rad^2) of the chosen joints, turned into [-pi, pi], to ``target``. Shape (num_envs,)."""
    asset: Articulation = env.scene[asset_cfg.name]
    angle = wrap_to_pi(asset.data.joint_pos[:, asset_cfg.joint_ids])
    return (angle - target).square().sum(dim=1)
