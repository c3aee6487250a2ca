"""The cart-pole: a force on the cart keeps the pole upright. Every number is Isaac Lab's."""

from __future__ import annotations

import math

import lift_lab.sim as sim_utils
from lift_lab.assets import ArticulationCfg, AssetBaseCfg
from lift_lab.envs import ManagerBasedRLEnvCfg
from lift_lab.envs.mirror import MirrorCfg
from lift_lab.managers import EventTermCfg as EventTerm
from lift_lab.managers import MetricsTermCfg as MetricTerm
from lift_lab.managers import ObservationGroupCfg as ObsGroup
from lift_lab.managers import ObservationTermCfg as ObsTerm
from lift_lab.managers import RewardTermCfg as RewTerm
from lift_lab.managers import SceneEntityCfg
from lift_lab.managers import TerminationTermCfg as DoneTerm
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.utils import configclass
from lift_lab_assets.robots.cartpole import CARTPOLE_CFG, CARTPOLE_MIRROR

from . import mdp

_CART = SceneEntityCfg("robot", joint_names=["slider_to_cart"])
_POLE = SceneEntityCfg("robot", joint_names=["cart_to_pole"])


@configclass
class CartpoleSceneCfg(InteractiveSceneCfg):
    """A cart on a rail above the floor."""

    robot: ArticulationCfg = CARTPOLE_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
    ground = AssetBaseCfg(prim_path="/World/ground", spawn=sim_utils.GroundPlaneCfg(size=(100.0, 100.0)))
    light = AssetBaseCfg(prim_path="/World/light", spawn=sim_utils.DomeLightCfg(color=(0.9, 0.9, 0.9)))


@configclass
class ActionsCfg:
    """One force of 100 N per unit of action, along the rail."""

    joint_effort = mdp.JointEffortActionCfg(asset_name="robot", joint_names=["slider_to_cart"], scale=100.0)


@configclass
class ObservationsCfg:
    """Four numbers: positions and velocities of cart and pole."""

    @configclass
    class PolicyCfg(ObsGroup):
        """Observations of the policy."""

        joint_pos_rel = ObsTerm(func=mdp.joint_pos_rel)
        joint_vel_rel = ObsTerm(func=mdp.joint_vel_rel)

        def __post_init__(self):
            self.enable_corruption = False
            self.concatenate_terms = True

    policy: PolicyCfg = PolicyCfg()


@configclass
class EventCfg:
    """A reset puts the cart anywhere within a metre and leans the pole by up to 45 degrees."""

    reset_cart_position = EventTerm(
        func=mdp.reset_joints_by_offset,
        mode="reset",
        params={"asset_cfg": _CART, "position_range": (-1.0, 1.0), "velocity_range": (-0.5, 0.5)},
    )
    reset_pole_position = EventTerm(
        func=mdp.reset_joints_by_offset,
        mode="reset",
        params={
            "asset_cfg": _POLE,
            "position_range": (-0.25 * math.pi, 0.25 * math.pi),
            "velocity_range": (-0.25 * math.pi, 0.25 * math.pi),
        },
    )


@configclass
class RewardsCfg:
    """Stay alive, upright and calm."""

    alive = RewTerm(func=mdp.is_alive, weight=1.0)
    terminating = RewTerm(func=mdp.is_terminated, weight=-2.0)
    pole_pos = RewTerm(func=mdp.joint_pos_target_l2, weight=-1.0, params={"asset_cfg": _POLE, "target": 0.0})
    cart_vel = RewTerm(func=mdp.joint_vel_l1, weight=-0.01, params={"asset_cfg": _CART})
    pole_vel = RewTerm(func=mdp.joint_vel_l1, weight=-0.005, params={"asset_cfg": _POLE})


@configclass
class MetricsCfg:
    """Numbers of each episode for the log."""

    success = MetricTerm(func=mdp.pole_balanced, reduce="max", log_as="success_rate")
    """1 if the pole stands when time has run out."""


@configclass
class TerminationsCfg:
    """Time, or the cart more than 3 m from the middle."""

    time_out = DoneTerm(func=mdp.time_out, time_out=True)
    cart_out_of_bounds = DoneTerm(
        func=mdp.joint_pos_out_of_manual_limit, params={"asset_cfg": _CART, "bounds": (-3.0, 3.0)}
    )


@configclass
class CartpoleEnvCfg(ManagerBasedRLEnvCfg):
    """``Cartpole``: 60 control steps a second for 5 s."""

    scene: CartpoleSceneCfg = CartpoleSceneCfg(num_envs=4096, env_spacing=4.0)
    observations: ObservationsCfg = ObservationsCfg()
    actions: ActionsCfg = ActionsCfg()
    events: EventCfg = EventCfg()
    rewards: RewardsCfg = RewardsCfg()
    metrics: MetricsCfg = MetricsCfg()
    terminations: TerminationsCfg = TerminationsCfg()

    def __post_init__(self):
        self.mirror = MirrorCfg(assets={"robot": CARTPOLE_MIRROR})
        self.decimation = 2
        self.episode_length_s = 5.0
        self.viewer.eye = (5.5, 0.0, 3.4)
        self.viewer.lookat = (0.0, 0.0, 1.9)
        self.sim.dt = 1.0 / 120.0
        self.sim.render_interval = self.decimation


@configclass
class CartpoleEnvCfg_PLAY(CartpoleEnvCfg):
    """The cart-pole for watching: few environments."""

    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
