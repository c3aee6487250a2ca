"""The reach task with a Franka Panda driven by poses of the hand."""

from __future__ import annotations

from lift_lab.controllers import DifferentialIKControllerCfg
from lift_lab.utils import configclass
from lift_lab_assets.robots.franka import FRANKA_PANDA_HIGH_PD_CFG
from lift_lab_tasks.manager_based.manipulation.reach import mdp

from . import joint_pos_env_cfg


@configclass
class FrankaReachEnvCfg(joint_pos_env_cfg.FrankaReachEnvCfg):
    """``Reach-Franka-IK-Abs``: seven numbers, position (m) and quaternion (wxyz), in the robot's root frame.

    The controlled frame is the hand's frame, to which the command refers. So the command itself is an action that
    solves the task. Isaac Lab controls a point 10.7 cm before the hand.
    """

    def __post_init__(self):
        super().__post_init__()
        self.scene.robot = FRANKA_PANDA_HIGH_PD_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
        self.actions.arm_action = mdp.DifferentialInverseKinematicsActionCfg(
            asset_name="robot",
            joint_names=["panda_joint.*"],
            body_name="panda_hand",
            controller=DifferentialIKControllerCfg(command_type="pose", use_relative_mode=False, ik_method="dls"),
        )


@configclass
class FrankaReachEnvCfg_PLAY(FrankaReachEnvCfg):
    """The task for watching: few environments, no observation noise."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
        self.observations.policy.enable_corruption = False
