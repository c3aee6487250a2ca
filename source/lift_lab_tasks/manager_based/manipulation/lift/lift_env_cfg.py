"""The lift task without a robot: scene, commands, observations, rewards and the rest.

Rewards, command ranges and terminations are those of Isaac Lab's lift task. The paper trained that task: "Adaptive
Robotic Arm Control: Leveraging Curriculum Learning and Deep Reinforcement Learning for Efficient Pick-and-Lift
Operations Through Simulation". The config of a robot sets the fields that are MISSING here.
"""

from __future__ import annotations

from typing import Annotated, Any

import lift_lab.sim as sim_utils
from lift_lab.assets import ArticulationCfg, AssetBaseCfg, DeformableObjectCfg, RigidObjectCfg
from lift_lab.envs import ManagerBasedRLEnvCfg
from lift_lab.managers import EventTermCfg as EventTerm
from lift_lab.managers import MetricsTermCfg as MetricTerm
from lift_lab.managers import ObservationGroupCfg as ObsGroup
from lift_lab.managers import ObservationTermCfg as ObsTerm
from lift_lab.managers import RewardTermCfg as RewTerm
from lift_lab.managers import SceneEntityCfg
from lift_lab.managers import TerminationTermCfg as DoneTerm
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.sensors import FrameTransformerCfg
from lift_lab.utils import MISSING, configclass
from lift_lab_assets.files import ASSETS_USD_DIR

from . import mdp


@configclass
class ObjectTableSceneCfg(InteractiveSceneCfg):
    """A robot on a table with an object before it."""

    robot: ArticulationCfg = MISSING
    ee_frame: FrameTransformerCfg = MISSING
    """Frame transformer whose first target is the end effector."""
    object: RigidObjectCfg | DeformableObjectCfg = MISSING
    table = AssetBaseCfg(
        prim_path="{ENV_REGEX_NS}/Table",
        init_state=AssetBaseCfg.InitialStateCfg(pos=(0.5, 0.0, 0.0), rot=(0.70710678, 0.0, 0.0, 0.70710678)),
        spawn=sim_utils.UsdFileCfg(usd_path=str(ASSETS_USD_DIR / "table.usda")),
    )
    plane = AssetBaseCfg(
        prim_path="/World/GroundPlane",
        init_state=AssetBaseCfg.InitialStateCfg(pos=(0.0, 0.0, -1.05)),
        spawn=sim_utils.GroundPlaneCfg(),
    )
    light = AssetBaseCfg(prim_path="/World/light", spawn=sim_utils.DomeLightCfg(color=(0.75, 0.75, 0.75)))


@configclass
class CommandsCfg:
    """Goal position of the object, in the robot's root frame."""

    object_pose = mdp.ObjectPoseCommandCfg(
        asset_name="robot",
        body_name=MISSING,
        resampling_time_range=(5.0, 5.0),
        debug_vis=True,
        ranges=mdp.ObjectPoseCommandCfg.Ranges(
            pos_x=(0.4, 0.6),
            pos_y=(-0.25, 0.25),
            pos_z=(0.25, 0.5),
            roll=(0.0, 0.0),
            pitch=(0.0, 0.0),
            yaw=(0.0, 0.0),
        ),
    )


@configclass
class ActionsCfg:
    """Arm and gripper."""

    arm_action: mdp.JointPositionActionCfg | mdp.DifferentialInverseKinematicsActionCfg = MISSING
    gripper_action: mdp.BinaryJointPositionActionCfg = MISSING


@configclass
class ObservationsCfg:
    """36 numbers for a Franka: 9 joint positions, 9 joint velocities, 3 object position, 7 command, 8 last action."""

    @configclass
    class PolicyCfg(ObsGroup):
        """Observations of the policy."""

        joint_pos = ObsTerm(func=mdp.joint_pos_rel)
        joint_vel = ObsTerm(func=mdp.joint_vel_rel)
        object_position = ObsTerm(func=mdp.object_position_in_robot_root_frame)
        target_object_position = ObsTerm(func=mdp.generated_commands, params={"command_name": "object_pose"})
        actions = ObsTerm(func=mdp.last_action)

        def __post_init__(self):
            self.enable_corruption = True
            self.concatenate_terms = True

    policy: PolicyCfg = PolicyCfg()


@configclass
class EventCfg:
    """Events at a reset."""

    reset_all = EventTerm(func=mdp.reset_scene_to_default, mode="reset")
    reset_object_position = EventTerm(
        func=mdp.reset_root_state_uniform,
        mode="reset",
        params={
            "pose_range": {"x": (-0.1, 0.1), "y": (-0.25, 0.25), "z": (0.0, 0.0)},
            "velocity_range": {},
            "asset_cfg": SceneEntityCfg("object", body_names="Object"),
        },
    )


@configclass
class RewardsCfg:
    """The paper's Eqs. (2)-(6) and Isaac Lab's reaching reward, which its Figure 12 shows."""

    reaching_object = RewTerm(func=mdp.object_ee_distance, params={"std": 0.1}, weight=1.0)
    lifting_object = RewTerm(func=mdp.object_is_lifted, params={"minimal_height": 0.04}, weight=15.0)
    object_goal_tracking = RewTerm(
        func=mdp.object_goal_distance,
        params={"std": 0.3, "minimal_height": 0.04, "command_name": "object_pose"},
        weight=16.0,
    )
    object_goal_tracking_fine_grained = RewTerm(
        func=mdp.object_goal_distance,
        params={"std": 0.05, "minimal_height": 0.04, "command_name": "object_pose"},
        weight=5.0,
    )
    action_rate = RewTerm(func=mdp.action_rate_l2, weight=-1e-4)
    joint_vel = RewTerm(func=mdp.joint_vel_l2, weight=-1e-4, params={"asset_cfg": SceneEntityCfg("robot")})


_SUCCESS = {"command_name": "object_pose", "threshold": 0.02}
"""The paper's Eq. (7)."""


@configclass
class MetricsCfg:
    """Numbers of each episode for the log, beside the hand's errors that come with the command."""

    success = MetricTerm(func=mdp.object_reached_goal, params=_SUCCESS, reduce="max", log_as="success_rate")
    """1 once the object came near its goal."""
    object_position_error = MetricTerm(
        func=mdp.object_position_error,
        params={"command_name": "object_pose"},
        reduce="last",
        log_as="object_pose/object_position_error",
    )
    first_pick_drop = MetricTerm(
        func=mdp.first_pick_drop,
        params={"heights_m": (0.03, 0.06)},
        reduce="max",
        log_as="object_pose/first_pick_drop",
    )
    squared_action_change = MetricTerm(func=mdp.action_rate_l2, log_as="object_pose/squared_action_change")
    """The paper's Eq. (5)."""
    squared_joint_acceleration = MetricTerm(
        func=mdp.squared_joint_acceleration,
        params={"asset_cfg": SceneEntityCfg("robot", joint_names=[".*"])},
        log_as="object_pose/squared_joint_acceleration",
    )
    time_to_success_s = MetricTerm(
        func=mdp.time_to_success_s, params=_SUCCESS, reduce="first", log_as="object_pose/time_to_success_s"
    )
    """Time to success, over the episodes that succeeded."""


@configclass
class TerminationsCfg:
    """The paper's Eqs. (8) and (9)."""

    time_out = DoneTerm(func=mdp.time_out, time_out=True)
    object_dropping = DoneTerm(
        func=mdp.root_height_below_minimum,
        params={"minimum_height": -0.05, "asset_cfg": SceneEntityCfg("object")},
    )


@configclass
class LiftEnvCfg(ManagerBasedRLEnvCfg):
    """The lift task, 50 control steps a second for 5 s."""

    scene: ObjectTableSceneCfg = ObjectTableSceneCfg(num_envs=4096, env_spacing=2.5)
    observations: ObservationsCfg = ObservationsCfg()
    actions: ActionsCfg = ActionsCfg()
    commands: CommandsCfg = CommandsCfg()
    rewards: RewardsCfg = RewardsCfg()
    metrics: MetricsCfg = MetricsCfg()
    terminations: TerminationsCfg = TerminationsCfg()
    events: Annotated[Any, EventCfg] = EventCfg()

    def __post_init__(self):
        self.decimation = 4
        self.episode_length_s = 5.0
        self.sim.dt = 0.005
        self.sim.render_interval = self.decimation
        self.sim.mujoco.integrator = "implicitfast"
        self.sim.mujoco.cone = "pyramidal"
        self.sim.mujoco.impratio = 1.0
        self.sim.mujoco.iterations = 10
        self.sim.mujoco.ls_iterations = 20
        self.sim.mujoco.island = False
        self.sim.mujoco.warmstart = False
        self.viewer.eye = (1.7, 1.3, 0.9)
        self.viewer.lookat = (0.35, 0.0, 0.25)
