"""PPO settings of the Franka lift tasks in task space: the same, a folder of runs for each kind of action."""

from __future__ import annotations

from lift_lab.utils import configclass

from .rsl_rl_ppo_cfg import LiftCubePPORunnerCfg


@configclass
class LiftCubeIKRelPPORunnerCfg(LiftCubePPORunnerCfg):
    """For changes of the tool's pose."""

    experiment_name = "franka_lift_ik_rel"


@configclass
class LiftCubeIKAbsPPORunnerCfg(LiftCubePPORunnerCfg):
    """For poses of the tool."""

    experiment_name = "franka_lift_ik_abs"
