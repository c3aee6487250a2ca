"""The lift task with a Franka Panda driven by joint positions."""

from __future__ import annotations

from typing import Annotated, Any

from lift_lab.assets import RigidObjectCfg
from lift_lab.envs.mirror import MirrorCfg
from lift_lab.managers import CurriculumTermCfg as CurrTerm
from lift_lab.markers.config import FRAME_MARKER_CFG
from lift_lab.sensors import FrameTransformerCfg, OffsetCfg
from lift_lab.sim.spawners.from_files.from_files_cfg import UsdFileCfg
from lift_lab.utils import configclass
from lift_lab_assets.files import ASSETS_USD_DIR
from lift_lab_assets.robots.franka import FRANKA_PANDA_CFG, FRANKA_PANDA_MIRROR
from lift_lab_tasks.manager_based.manipulation.lift import mdp
from lift_lab_tasks.manager_based.manipulation.lift.lift_env_cfg import LiftEnvCfg


@configclass
class ExplorationCfg:
    """Exploration aids, part of every curriculum of this task."""

    gripper_hold = CurrTerm(
        func=mdp.hold_gripper_while_hovering,
        params={"close_time_s": 0.1, "reached": 0.65, "lifted": 0.1},
        training_only=True,
    )
    missed_goals = CurrTerm(
        func=mdp.practise_missed_goals, params={"share": 0.3, "start_step": 18000}, training_only=True
    )


@configclass
class FrankaCubeLiftEnvCfg(LiftEnvCfg):
    """``Lift-Cube-Franka``: the baseline, with penalties of constant weight."""

    curriculum: Annotated[Any, ExplorationCfg] = ExplorationCfg()

    def __post_init__(self):
        super().__post_init__()
        self.scene.robot = FRANKA_PANDA_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
        self.mirror = MirrorCfg(assets={"robot": FRANKA_PANDA_MIRROR})
        self.actions.arm_action = mdp.JointPositionActionCfg(
            asset_name="robot", joint_names=["panda_joint.*"], scale=0.5, use_default_offset=True
        )
        self.actions.gripper_action = mdp.BinaryJointPositionActionCfg(
            asset_name="robot",
            joint_names=["panda_finger.*"],
            open_command_expr={"panda_finger_.*": 0.04},
            close_command_expr={"panda_finger_.*": 0.0},
        )
        self.commands.object_pose.body_name = "panda_hand"
        self.metrics.squared_joint_acceleration.params["asset_cfg"].joint_names = ["panda_joint.*"]
        self.scene.object = RigidObjectCfg(
            prim_path="{ENV_REGEX_NS}/Object",
            init_state=RigidObjectCfg.InitialStateCfg(pos=(0.5, 0.0, 0.02)),
            spawn=UsdFileCfg(usd_path=str(ASSETS_USD_DIR / "cube.usda")),
        )
        frame_marker = FRAME_MARKER_CFG.replace(prim_path="/Visuals/FrameTransformer")
        frame_marker.markers["frame"].scale = (0.1, 0.1, 0.1)
        self.scene.ee_frame = FrameTransformerCfg(
            prim_path="{ENV_REGEX_NS}/Robot/panda_link0",
            visualizer_cfg=frame_marker,
            target_frames=[
                FrameTransformerCfg.FrameCfg(
                    prim_path="{ENV_REGEX_NS}/Robot/panda_hand",
                    name="end_effector",
                    offset=OffsetCfg(pos=(0.0, 0.0, 0.1034)),
                )
            ],
        )


@configclass
class CurriculumCfg(ExplorationCfg):
    """Penalty annealing (the paper's section 3.4)."""

    action_rate = CurrTerm(
        func=mdp.modify_reward_weight,
        params={"term_name": "action_rate", "weight": -1e-1, "num_steps": 18000},
    )
    joint_vel = CurrTerm(
        func=mdp.modify_reward_weight, params={"term_name": "joint_vel", "weight": -1e-1, "num_steps": 18000}
    )


@configclass
class FrankaCubeLiftCurriculumEnvCfg(FrankaCubeLiftEnvCfg):
    """``Lift-Cube-Franka-CL``: penalties of motion grow once the skill exists."""

    curriculum: CurriculumCfg = CurriculumCfg()


@configclass
class FrankaCubeLiftEnvCfg_PLAY(FrankaCubeLiftEnvCfg):
    """The baseline for watching: few environments, no observation noise."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
        self.scene.env_spacing = 2.5
        self.observations.policy.enable_corruption = False


@configclass
class FrankaCubeLiftCurriculumEnvCfg_PLAY(FrankaCubeLiftCurriculumEnvCfg):
    """The curriculum task for watching: few environments, no observation noise."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
        self.scene.env_spacing = 2.5
        self.observations.policy.enable_corruption = False
