"""The lift task with a Franka Panda driven by changes of the tool's pose."""

from __future__ import annotations

from lift_lab.controllers import DifferentialIKControllerCfg
from lift_lab.utils import configclass
from lift_lab_tasks.manager_based.manipulation.lift import mdp

from . import ik_curricula, joint_pos_env_cfg


@configclass
class FrankaCubeLiftEnvCfg(joint_pos_env_cfg.FrankaCubeLiftEnvCfg):
    """``Lift-Cube-Franka-IK-Rel``: six numbers, half a metre and half a radian per unit, and the gripper.

    The controlled frame is the tool centre of ``ee_frame``, 10.34 cm before the hand (Isaac Lab: 10.7 cm). The arm has
    the gains of the joint-position task: with Isaac Lab's, which follow faster, exploration knocks the cube away.
    """

    curriculum: ik_curricula.ExplorationCfg = ik_curricula.ExplorationCfg()

    def __post_init__(self):
        super().__post_init__()
        self.actions.arm_action = mdp.DifferentialInverseKinematicsActionCfg(
            asset_name="robot",
            joint_names=["panda_joint.*"],
            body_name="panda_hand",
            controller=DifferentialIKControllerCfg(command_type="pose", use_relative_mode=True, ik_method="dls"),
            scale=0.5,
            body_offset=mdp.DifferentialInverseKinematicsActionCfg.OffsetCfg(pos=(0.0, 0.0, 0.1034)),
        )


@configclass
class FrankaCubeLiftEnvCfg_PLAY(FrankaCubeLiftEnvCfg):
    """The task for watching: few environments, no observation noise."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
        self.observations.policy.enable_corruption = False
