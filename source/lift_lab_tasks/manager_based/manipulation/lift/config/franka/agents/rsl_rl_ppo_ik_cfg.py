"""PPO settings of the Franka lift tasks in task space: less noise at first, a folder for each kind of action.

Their ``gamma`` begins with 0.99, to find the grasp, and ends with 0.97, for the last centimetre (docs/learning.md).
"""

from __future__ import annotations

from lift_lab.utils import configclass

from .rsl_rl_ppo_cfg import LiftCubePPORunnerCfg


@configclass
class LiftCubeIKRelPPORunnerCfg(LiftCubePPORunnerCfg):
    """For changes of the tool's pose, where one is half a metre or half a radian; the gripper explores as ever."""

    experiment_name = "franka_lift_ik_rel"

    def __post_init__(self):
        super().__post_init__()
        self.policy.init_noise_std = [0.3, 0.3, 0.3, 0.2, 0.2, 0.2, 1.0]
        self.algorithm.gamma, self.algorithm.gamma_final = 0.99, 0.97


@configclass
class LiftCubeIKAbsPPORunnerCfg(LiftCubePPORunnerCfg):
    """For poses of the tool, in m and as a quaternion: begins about the pose at a reset; nothing pulls it to zero."""

    experiment_name = "franka_lift_ik_abs"

    def __post_init__(self):
        super().__post_init__()
        self.policy.init_noise_std = [0.15, 0.15, 0.15, 0.1, 0.1, 0.1, 0.1, 1.0]
        self.policy.init_action_mean = [0.46, 0.0, 0.39, 0.0, 0.92, 0.0, 0.39, 0.0]
        self.algorithm.mean_reg_coef = 0.0
        self.algorithm.gamma, self.algorithm.gamma_final = 0.99, 0.97
