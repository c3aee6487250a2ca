"""A tiny world for environment tests: a two-joint arm on a post and a ball that touches nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import MISSING
from pathlib import Path
from typing import Any

import pytest
import torch

import lift_lab.envs.mdp as mdp
import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg, RigidObjectCfg
from lift_lab.envs import ManagerBasedRLEnv, ManagerBasedRLEnvCfg
from lift_lab.managers import EventTermCfg, ObservationGroupCfg, ObservationTermCfg, TerminationTermCfg
from lift_lab.scene import InteractiveSceneCfg
from lift_lab.utils import configclass

DEFAULT_JOINT_POS = {"shoulder": 0.3, "elbow": -0.2}


@pytest.fixture(scope="session")
def arm_file(tmp_path_factory, author_arm) -> Path:
    return author_arm(tmp_path_factory.mktemp("usd") / "arm.usda", drives=False)


@configclass
class SceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg = MISSING
    ball = RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Ball",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(2.0, 0.0, 1.0)),
        spawn=sim_utils.SphereCfg(
            radius=0.1,
            rigid_props=sim_utils.RigidBodyPropertiesCfg(disable_gravity=True),
            mass_props=sim_utils.MassPropertiesCfg(mass=0.5),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )


@configclass
class ActionsCfg:
    joints = mdp.JointPositionActionCfg(asset_name="robot", joint_names=[".*"], scale=0.5)


@configclass
class ObservationsCfg:
    @configclass
    class PolicyCfg(ObservationGroupCfg):
        joint_pos = ObservationTermCfg(func=mdp.joint_pos)
        elbow = ObservationTermCfg(func=mdp.body_pose_w)
        actions = ObservationTermCfg(func=mdp.last_action)

    policy: PolicyCfg = PolicyCfg()


@configclass
class EventsCfg:
    default = EventTermCfg(func=mdp.reset_scene_to_default, mode="reset")


@configclass
class TerminationsCfg:
    time_out = TerminationTermCfg(func=mdp.time_out, time_out=True)


@configclass
class EnvCfg(ManagerBasedRLEnvCfg):
    scene: SceneCfg = SceneCfg(num_envs=3, env_spacing=2.0)
    observations: ObservationsCfg = ObservationsCfg()
    actions: ActionsCfg = ActionsCfg()
    events: EventsCfg = EventsCfg()
    rewards: object = {}
    terminations: TerminationsCfg = TerminationsCfg()

    def __post_init__(self):
        self.decimation = 4
        self.episode_length_s = 0.2
        self.seed = 7
        self.sim.dt = 0.005
        self.sim.device = "cpu"


@pytest.fixture
def make_cfg(arm_file) -> Callable[..., EnvCfg]:
    """A config with some fields replaced: 3 environments of 4 x 5 ms, episodes of 10 steps."""

    def make(physics: str = "native", num_envs: int = 3, **fields: Any) -> EnvCfg:
        cfg = EnvCfg()
        cfg.scene.num_envs = num_envs
        cfg.scene.robot = ArticulationCfg(
            prim_path="{ENV_REGEX_NS}/Arm",
            spawn=sim_utils.UsdFileCfg(usd_path=str(arm_file)),
            init_state=ArticulationCfg.InitialStateCfg(joint_pos=DEFAULT_JOINT_POS),
            actuators={
                "all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=50.0, damping=5.0, effort_limit_sim=50.0)
            },
        )
        cfg.sim.physics = physics
        for name, value in fields.items():
            assert hasattr(cfg, name)
            setattr(cfg, name, value)
        return cfg

    return make


@pytest.fixture
def make_env(make_cfg) -> Iterator[Callable[..., ManagerBasedRLEnv]]:
    """An environment of :func:`make_cfg`, closed at the end of the test."""
    opened = []

    def make(env_class: type = ManagerBasedRLEnv, cfg: Any = None, **fields: Any) -> ManagerBasedRLEnv:
        env = env_class(make_cfg(**fields) if cfg is None else cfg)
        opened.append(env)
        return env

    yield make
    for env in opened:
        env.close()


@pytest.fixture(scope="session")
def elbow_position() -> Callable[[torch.Tensor], torch.Tensor]:
    """Forward kinematics of the elbow in the environment's frame, from joint positions of shape (n, 2)."""

    def compute(joint_pos: torch.Tensor) -> torch.Tensor:
        q = joint_pos[:, 0]
        return torch.stack((0.4 * torch.cos(q), torch.zeros_like(q), 0.5 - 0.4 * torch.sin(q)), dim=-1)

    return compute


@pytest.fixture(scope="session")
def quarter_turn_z() -> torch.Tensor:
    """A rotation of 90 degrees about z, shape (4,)."""
    return torch.tensor([math.cos(math.pi / 4), 0.0, 0.0, math.sin(math.pi / 4)])
