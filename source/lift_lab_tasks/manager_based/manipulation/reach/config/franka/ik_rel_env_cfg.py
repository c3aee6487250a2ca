"""The reach task with a Franka Panda driven by changes of the hand's pose."""

from __future__ import annotations

from lift_lab.controllers import DifferentialIKControllerCfg
from lift_lab.utils import configclass
from lift_lab_assets.robots.franka import FRANKA_PANDA_HIGH_PD_CFG
from lift_lab_tasks.manager_based.manipulation.reach import mdp

from . import joint_pos_env_cfg


@configclass
class FrankaReachEnvCfg(joint_pos_env_cfg.FrankaReachEnvCfg):
    """``Reach-Franka-IK-Rel``: six numbers, half a metre and half a radian per unit, in the robot's root frame.

    The controlled frame is the hand's own, which the command is for (Isaac Lab controls a point 10.7 cm before it).
    """

    def __post_init__(self):
        super().__post_init__()
        self.scene.robot = FRANKA_PANDA_HIGH_PD_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
        self.actions.arm_action = mdp.DifferentialInverseKinematicsActionCfg(
            asset_name="robot",
            joint_names=["panda_joint.*"],
            body_name="panda_hand",
            controller=DifferentialIKControllerCfg(command_type="pose", use_relative_mode=True, ik_method="dls"),
            scale=0.5,
        )


@configclass
class FrankaReachEnvCfg_PLAY(FrankaReachEnvCfg):
    """The task for watching: few environments, no observation noise."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
        self.observations.policy.enable_corruption = False
