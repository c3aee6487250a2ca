"""The cabinet task with a Franka Panda driven by joint positions."""

from __future__ import annotations

from lift_lab.sensors import FrameTransformerCfg, OffsetCfg
from lift_lab.utils import configclass
from lift_lab_assets.robots.franka import FRANKA_PANDA_CFG
from lift_lab_tasks.manager_based.manipulation.cabinet import mdp
from lift_lab_tasks.manager_based.manipulation.cabinet.cabinet_env_cfg import FRAME_MARKER_SMALL_CFG, CabinetEnvCfg


def _frame(body: str, name: str, height: float) -> FrameTransformerCfg.FrameCfg:
    return FrameTransformerCfg.FrameCfg(
        prim_path=f"{{ENV_REGEX_NS}}/Robot/{body}", name=name, offset=OffsetCfg(pos=(0.0, 0.0, height))
    )


@configclass
class FrankaCabinetEnvCfg(CabinetEnvCfg):
    """``Open-Drawer-Franka``.

    The fingers have Isaac Lab's 2000 N/m and 100 N s/m. With the 350 N/m of the lift task each finger would hold the 2
    cm bar with only 3.5 N, and the hand would slip off.
    """

    def __post_init__(self):
        super().__post_init__()
        self.scene.robot = FRANKA_PANDA_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
        self.scene.robot.actuators["panda_hand"].stiffness = 2000.0
        self.scene.robot.actuators["panda_hand"].damping = 100.0
        self.actions.arm_action = mdp.JointPositionActionCfg(
            asset_name="robot", joint_names=["panda_joint.*"], scale=1.0, use_default_offset=True
        )
        self.actions.gripper_action = mdp.BinaryJointPositionActionCfg(
            asset_name="robot",
            joint_names=["panda_finger.*"],
            open_command_expr={"panda_finger_.*": 0.04},
            close_command_expr={"panda_finger_.*": 0.0},
        )
        # The terms count on this order: tool centre, left fingertip, right fingertip
        self.scene.ee_frame = FrameTransformerCfg(
            prim_path="{ENV_REGEX_NS}/Robot/panda_link0",
            visualizer_cfg=FRAME_MARKER_SMALL_CFG.replace(prim_path="/Visuals/EndEffectorFrameTransformer"),
            target_frames=[
                _frame("panda_hand", "ee_tcp", 0.1034),
                _frame("panda_leftfinger", "tool_leftfinger", 0.046),
                _frame("panda_rightfinger", "tool_rightfinger", 0.046),
            ],
        )
        self.rewards.approach_gripper_handle.params["offset"] = 0.04
        self.rewards.grasp_handle.params["open_joint_pos"] = 0.04
        self.rewards.grasp_handle.params["asset_cfg"].joint_names = ["panda_finger_.*"]


@configclass
class FrankaCabinetEnvCfg_PLAY(FrankaCabinetEnvCfg):
    """The task for watching: few environments, no observation noise."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
        self.scene.env_spacing = 2.5
        self.observations.policy.enable_corruption = False
