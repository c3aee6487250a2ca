"""The reach task without a robot. Rewards, command ranges, noise and curriculum are Isaac Lab's.

The physics step is 10 ms instead of Isaac Lab's 17 ms, so that a contact with the table is resolved. The control step
is 30 ms instead of 33 ms. A robot's config sets the fields that are MISSING.
"""

from __future__ import annotations

import lift_lab.sim as sim_utils
from lift_lab.assets import ArticulationCfg, AssetBaseCfg
from lift_lab.envs import ManagerBasedRLEnvCfg
from lift_lab.managers import ActionTermCfg as ActionTerm
from lift_lab.managers import CurriculumTermCfg as CurrTerm
from lift_lab.managers import EventTermCfg as EventTerm
from lift_lab.managers import MetricsTermCfg as MetricTerm
from lift_lab.managers import ObservationGroupCfg as ObsGroup
from lift_lab.managers import ObservationTermCfg as ObsTerm
from lift_lab.managers import RewardTermCfg as RewTerm
from lift_lab.managers import SceneEntityCfg
from lift_lab.managers import TerminationTermCfg as DoneTerm
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.utils import MISSING, configclass
from lift_lab.utils.noise import AdditiveUniformNoiseCfg as Unoise
from lift_lab_assets.files import ASSETS_USD_DIR

from . import mdp


@configclass
class ReachSceneCfg(InteractiveSceneCfg):
    """A robot on a table."""

    robot: ArticulationCfg = MISSING
    table = AssetBaseCfg(
        prim_path="{ENV_REGEX_NS}/Table",
        init_state=AssetBaseCfg.InitialStateCfg(pos=(0.5, 0.0, 0.0), rot=(0.70710678, 0.0, 0.0, 0.70710678)),
        spawn=sim_utils.UsdFileCfg(usd_path=str(ASSETS_USD_DIR / "table.usda")),
    )
    ground = AssetBaseCfg(
        prim_path="/World/ground",
        init_state=AssetBaseCfg.InitialStateCfg(pos=(0.0, 0.0, -1.05)),
        spawn=sim_utils.GroundPlaneCfg(),
    )
    light = AssetBaseCfg(prim_path="/World/light", spawn=sim_utils.DomeLightCfg(color=(0.75, 0.75, 0.75)))


@configclass
class CommandsCfg:
    """Goal pose of the end effector, in the robot's root frame; a new pose every 4 s."""

    ee_pose = mdp.UniformPoseCommandCfg(
        asset_name="robot",
        body_name=MISSING,
        resampling_time_range=(4.0, 4.0),
        debug_vis=True,
        ranges=mdp.UniformPoseCommandCfg.Ranges(
            pos_x=(0.35, 0.65),
            pos_y=(-0.2, 0.2),
            pos_z=(0.15, 0.5),
            roll=(0.0, 0.0),
            pitch=MISSING,
            yaw=(-3.14, 3.14),
        ),
    )


@configclass
class ActionsCfg:
    """Arm, and a gripper where the robot's config has one."""

    arm_action: ActionTerm = MISSING
    gripper_action: ActionTerm | None = None


@configclass
class ObservationsCfg:
    """32 numbers for a Franka driven by joint positions: 9 and 9 of the joints, 7 command, 7 last action."""

    @configclass
    class PolicyCfg(ObsGroup):
        """Observations of the policy."""

        joint_pos = ObsTerm(func=mdp.joint_pos_rel, noise=Unoise(n_min=-0.01, n_max=0.01))
        joint_vel = ObsTerm(func=mdp.joint_vel_rel, noise=Unoise(n_min=-0.01, n_max=0.01))
        pose_command = ObsTerm(func=mdp.generated_commands, params={"command_name": "ee_pose"})
        actions = ObsTerm(func=mdp.last_action)

        def __post_init__(self):
            self.enable_corruption = True
            self.concatenate_terms = True

    policy: PolicyCfg = PolicyCfg()


@configclass
class EventCfg:
    """A reset scales every default joint position by a factor between a half and one and a half."""

    reset_robot_joints = EventTerm(
        func=mdp.reset_joints_by_scale,
        mode="reset",
        params={"position_range": (0.5, 1.5), "velocity_range": (0.0, 0.0)},
    )


@configclass
class RewardsCfg:
    """Track the pose, coarsely and finely, with little motion."""

    end_effector_position_tracking = RewTerm(
        func=mdp.position_command_error,
        weight=-0.2,
        params={"asset_cfg": SceneEntityCfg("robot", body_names=MISSING), "command_name": "ee_pose"},
    )
    end_effector_position_tracking_fine_grained = RewTerm(
        func=mdp.position_command_error_tanh,
        weight=0.1,
        params={"asset_cfg": SceneEntityCfg("robot", body_names=MISSING), "std": 0.1, "command_name": "ee_pose"},
    )
    end_effector_orientation_tracking = RewTerm(
        func=mdp.orientation_command_error,
        weight=-0.1,
        params={"asset_cfg": SceneEntityCfg("robot", body_names=MISSING), "command_name": "ee_pose"},
    )
    action_rate = RewTerm(func=mdp.action_rate_l2, weight=-1e-4)
    joint_vel = RewTerm(func=mdp.joint_vel_l2, weight=-1e-4, params={"asset_cfg": SceneEntityCfg("robot")})


@configclass
class MetricsCfg:
    """Numbers of each episode for the log, beside the hand's errors that come with the command."""

    success = MetricTerm(func=mdp.pose_reached, reduce="max", log_as="success_rate")
    """1 once the hand was at its pose."""


@configclass
class TerminationsCfg:
    """Time alone."""

    time_out = DoneTerm(func=mdp.time_out, time_out=True)


@configclass
class CurriculumCfg:
    """Motion costs more once reaching is learned."""

    action_rate = CurrTerm(
        func=mdp.modify_reward_weight, params={"term_name": "action_rate", "weight": -0.005, "num_steps": 4500}
    )
    joint_vel = CurrTerm(
        func=mdp.modify_reward_weight, params={"term_name": "joint_vel", "weight": -0.001, "num_steps": 4500}
    )


@configclass
class ReachEnvCfg(ManagerBasedRLEnvCfg):
    """The reach task, 33 control steps a second for 12 s."""

    scene: ReachSceneCfg = ReachSceneCfg(num_envs=4096, env_spacing=2.5)
    observations: ObservationsCfg = ObservationsCfg()
    actions: ActionsCfg = ActionsCfg()
    commands: CommandsCfg = CommandsCfg()
    rewards: RewardsCfg = RewardsCfg()
    metrics: MetricsCfg = MetricsCfg()
    terminations: TerminationsCfg = TerminationsCfg()
    events: EventCfg = EventCfg()
    curriculum: CurriculumCfg = CurriculumCfg()

    def __post_init__(self):
        self.decimation = 3
        self.episode_length_s = 12.0
        self.viewer.eye = (1.7, 1.3, 0.9)
        self.viewer.lookat = (0.3, 0.0, 0.25)
        self.sim.dt = 0.01
        self.sim.render_interval = self.decimation
