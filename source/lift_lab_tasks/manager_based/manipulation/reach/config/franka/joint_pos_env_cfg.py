"""The reach task with a Franka Panda driven by joint positions."""

from __future__ import annotations

import math

from lift_lab.envs.mirror import MirrorCfg
from lift_lab.utils import configclass
from lift_lab_assets.robots.franka import FRANKA_PANDA_CFG, FRANKA_PANDA_MIRROR
from lift_lab_tasks.manager_based.manipulation.reach import mdp
from lift_lab_tasks.manager_based.manipulation.reach.reach_env_cfg import ReachEnvCfg


@configclass
class FrankaReachEnvCfg(ReachEnvCfg):
    """``Reach-Franka``: the hand, looking down, goes to the commanded pose."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.robot = FRANKA_PANDA_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
        self.mirror = MirrorCfg(assets={"robot": FRANKA_PANDA_MIRROR})
        self.actions.arm_action = mdp.JointPositionActionCfg(
            asset_name="robot", joint_names=["panda_joint.*"], scale=0.5, use_default_offset=True
        )
        self.commands.ee_pose.body_name = "panda_hand"
        self.commands.ee_pose.ranges.pitch = (math.pi, math.pi)
        self.rewards.end_effector_position_tracking.params["asset_cfg"].body_names = ["panda_hand"]
        self.rewards.end_effector_position_tracking_fine_grained.params["asset_cfg"].body_names = ["panda_hand"]
        self.rewards.end_effector_orientation_tracking.params["asset_cfg"].body_names = ["panda_hand"]


@configclass
class FrankaReachEnvCfg_PLAY(FrankaReachEnvCfg):
    """The task for watching: few environments, no observation noise."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
        self.observations.policy.enable_corruption = False
