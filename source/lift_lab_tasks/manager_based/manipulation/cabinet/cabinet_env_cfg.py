"""The cabinet task without a robot: a cabinet before the robot, its top drawer to be opened.

Rewards, events and drawer actuators are Isaac Lab's. The physics step is 5 ms in place of 17 ms, as grasping needs; a
control step is 20 ms. A robot's config sets the fields that are MISSING.
"""

from __future__ import annotations

import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg, AssetBaseCfg
from lift_lab.envs import ManagerBasedRLEnvCfg
from lift_lab.managers import ActionTermCfg as ActionTerm
from lift_lab.managers import EventTermCfg as EventTerm
from lift_lab.managers import MetricsTermCfg as MetricTerm
from lift_lab.managers import ObservationGroupCfg as ObsGroup
from lift_lab.managers import ObservationTermCfg as ObsTerm
from lift_lab.managers import RewardTermCfg as RewTerm
from lift_lab.managers import SceneEntityCfg
from lift_lab.managers import TerminationTermCfg as DoneTerm
from lift_lab.markers.config import FRAME_MARKER_CFG
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.sensors import FrameTransformerCfg, OffsetCfg
from lift_lab.utils import MISSING, configclass
from lift_lab_assets.files import ASSETS_USD_DIR

from . import mdp

FRAME_MARKER_SMALL_CFG = FRAME_MARKER_CFG.copy()
FRAME_MARKER_SMALL_CFG.markers["frame"].scale = (0.10, 0.10, 0.10)

_TOP_DRAWER = SceneEntityCfg("cabinet", joint_names=["drawer_top_joint"])


@configclass
class CabinetSceneCfg(InteractiveSceneCfg):
    """A robot on the floor, its front to the cabinet's front."""

    robot: ArticulationCfg = MISSING
    ee_frame: FrameTransformerCfg = MISSING
    """Frame transformer whose targets are the tool centre, the left and the right fingertip."""
    cabinet = ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Cabinet",
        spawn=sim_utils.UsdFileCfg(usd_path=str(ASSETS_USD_DIR / "cabinet.usda"), activate_contact_sensors=False),
        init_state=ArticulationCfg.InitialStateCfg(
            pos=(0.8, 0.0, 0.4),
            rot=(0.0, 0.0, 0.0, 1.0),
            joint_pos={".*": 0.0},
        ),
        actuators={
            "drawers": ImplicitActuatorCfg(
                joint_names_expr=["drawer_top_joint", "drawer_bottom_joint"],
                effort_limit_sim=87.0,
                stiffness=10.0,
                damping=1.0,
            ),
            "doors": ImplicitActuatorCfg(
                joint_names_expr=["door_left_joint", "door_right_joint"],
                effort_limit_sim=87.0,
                stiffness=10.0,
                damping=2.5,
            ),
        },
    )
    cabinet_frame = FrameTransformerCfg(
        prim_path="{ENV_REGEX_NS}/Cabinet/sektion",
        debug_vis=True,
        visualizer_cfg=FRAME_MARKER_SMALL_CFG.replace(prim_path="/Visuals/CabinetFrameTransformer"),
        target_frames=[
            FrameTransformerCfg.FrameCfg(
                prim_path="{ENV_REGEX_NS}/Cabinet/drawer_handle_top",
                name="drawer_handle_top",
                # z into the cabinet and y up: a hand whose left finger is above the handle
                offset=OffsetCfg(pos=(0.305, 0.0, 0.01), rot=(0.5, 0.5, -0.5, -0.5)),
            )
        ],
    )
    plane = AssetBaseCfg(prim_path="/World/GroundPlane", spawn=sim_utils.GroundPlaneCfg())
    light = AssetBaseCfg(prim_path="/World/light", spawn=sim_utils.DomeLightCfg(color=(0.75, 0.75, 0.75)))


@configclass
class ActionsCfg:
    """Arm and gripper."""

    arm_action: ActionTerm = MISSING
    gripper_action: mdp.BinaryJointPositionActionCfg = MISSING


@configclass
class ObservationsCfg:
    """31 numbers for a Franka: 9 and 9 of its joints, 1 and 1 of the drawer's, 3 to the handle, 8 last action."""

    @configclass
    class PolicyCfg(ObsGroup):
        """Observations of the policy."""

        joint_pos = ObsTerm(func=mdp.joint_pos_rel)
        joint_vel = ObsTerm(func=mdp.joint_vel_rel)
        cabinet_joint_pos = ObsTerm(func=mdp.joint_pos_rel, params={"asset_cfg": _TOP_DRAWER})
        cabinet_joint_vel = ObsTerm(func=mdp.joint_vel_rel, params={"asset_cfg": _TOP_DRAWER})
        rel_ee_drawer_distance = ObsTerm(func=mdp.rel_ee_drawer_distance)
        actions = ObsTerm(func=mdp.last_action)

        def __post_init__(self):
            self.enable_corruption = True
            self.concatenate_terms = True

    policy: PolicyCfg = PolicyCfg()


@configclass
class EventCfg:
    """Friction differs between environments; a reset varies the arm's pose."""

    robot_physics_material = EventTerm(
        func=mdp.randomize_rigid_body_material,
        mode="startup",
        params={
            "asset_cfg": SceneEntityCfg("robot", body_names=".*"),
            "static_friction_range": (0.8, 1.25),
            "dynamic_friction_range": (0.8, 1.25),
            "restitution_range": (0.0, 0.0),
            "num_buckets": 16,
        },
    )
    cabinet_physics_material = EventTerm(
        func=mdp.randomize_rigid_body_material,
        mode="startup",
        params={
            "asset_cfg": SceneEntityCfg("cabinet", body_names="drawer_handle_top"),
            "static_friction_range": (1.0, 1.25),
            "dynamic_friction_range": (1.0, 1.25),
            "restitution_range": (0.0, 0.0),
            "num_buckets": 16,
        },
    )
    reset_all = EventTerm(func=mdp.reset_scene_to_default, mode="reset")
    reset_robot_joints = EventTerm(
        func=mdp.reset_joints_by_offset,
        mode="reset",
        params={"position_range": (-0.1, 0.1), "velocity_range": (0.0, 0.0)},
    )


@configclass
class RewardsCfg:
    """Approach, grasp, open; and move calmly."""

    approach_ee_handle = RewTerm(func=mdp.approach_ee_handle, weight=2.0, params={"threshold": 0.2})
    align_ee_handle = RewTerm(func=mdp.align_ee_handle, weight=0.5)
    approach_gripper_handle = RewTerm(func=mdp.approach_gripper_handle, weight=5.0, params={"offset": MISSING})
    align_grasp_around_handle = RewTerm(func=mdp.align_grasp_around_handle, weight=0.125)
    grasp_handle = RewTerm(
        func=mdp.grasp_handle,
        weight=0.5,
        params={
            "threshold": 0.03,
            "open_joint_pos": MISSING,
            "asset_cfg": SceneEntityCfg("robot", joint_names=MISSING),
        },
    )
    open_drawer_bonus = RewTerm(func=mdp.open_drawer_bonus, weight=7.5, params={"asset_cfg": _TOP_DRAWER})
    multi_stage_open_drawer = RewTerm(func=mdp.multi_stage_open_drawer, weight=1.0, params={"asset_cfg": _TOP_DRAWER})
    action_rate_l2 = RewTerm(func=mdp.action_rate_l2, weight=-1e-2)
    joint_vel = RewTerm(func=mdp.joint_vel_l2, weight=-1e-4)


@configclass
class MetricsCfg:
    """Numbers of each episode for the log."""

    success = MetricTerm(func=mdp.drawer_is_open, reduce="max", log_as="success_rate")
    """1 once the drawer was open."""


@configclass
class TerminationsCfg:
    """Time alone."""

    time_out = DoneTerm(func=mdp.time_out, time_out=True)


@configclass
class CabinetEnvCfg(ManagerBasedRLEnvCfg):
    """The cabinet task, 50 control steps a second for 8 s."""

    scene: CabinetSceneCfg = CabinetSceneCfg(num_envs=4096, env_spacing=2.0)
    observations: ObservationsCfg = ObservationsCfg()
    actions: ActionsCfg = ActionsCfg()
    rewards: RewardsCfg = RewardsCfg()
    metrics: MetricsCfg = MetricsCfg()
    terminations: TerminationsCfg = TerminationsCfg()
    events: EventCfg = EventCfg()

    def __post_init__(self):
        self.decimation = 4
        self.episode_length_s = 8.0
        self.viewer.eye = (-1.2, 1.8, 1.5)
        self.viewer.lookat = (0.5, 0.0, 0.4)
        self.sim.dt = 0.005
        self.sim.render_interval = self.decimation
