"""Rewards of the lift task to choose from, e.g. ``env/rewards=ungated``; the gated ones are in lift_env_cfg."""

from __future__ import annotations

from lift_lab.utils import configclass
from lift_lab_tasks.manager_based.manipulation.lift.lift_env_cfg import RewardsCfg


@configclass
class UngatedRewardsCfg(RewardsCfg):
    """As the paper's Eqs. (3) and (4) are printed: the cube's distance to its goal counts on the table, too."""

    def __post_init__(self):
        self.object_goal_tracking.params["minimal_height"] = None
        self.object_goal_tracking_fine_grained.params["minimal_height"] = None
