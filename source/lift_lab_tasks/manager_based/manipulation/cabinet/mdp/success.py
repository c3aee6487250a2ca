"""Success of the cabinet task."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.ranges import FINITE

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv


def drawer_is_open(
    env: ManagerBasedRLEnv,
    threshold: Annotated[float, FINITE] = 0.3,
    asset_cfg: SceneEntityCfg = SceneEntityCfg("cabinet"),
) -> torch.Tensor:
    """Whether the top drawer is more than ``threshold`` (m) out. Shape (num_envs,)."""
    cabinet: Articulation = env.scene[asset_cfg.name]
    return cabinet.data.joint_pos[:, cabinet.joint_names.index("drawer_top_joint")] > threshold
