"""A value that cannot be meant for a field is named: a number for a configuration, null for a class."""

from typing import Any

import numpy as np
import pytest

from lift_lab.assets import Articulation, ArticulationCfg
from lift_lab.envs import ManagerBasedRLEnvCfg, mdp
from lift_lab.managers import EventTermCfg, ObservationTermCfg, RewardTermCfg
from lift_lab.markers import VisualizationMarkersCfg
from lift_lab.sim import CuboidCfg, SimulationCfg, UsdFileCfg
from lift_lab.terrains import TerrainImporterCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.field_kinds import kind_problem
from lift_lab.utils.noise import GaussianNoiseCfg
from lift_lab.utils.ranges import first_problem, may_be_none
from lift_lab_assets import CARTPOLE_CFG
from lift_lab_rl.rsl_rl import RslRlPpoAlgorithmCfg

NULL: Any = None
NUMBER: Any = 5


class MyArticulation(Articulation):
    """A class of a user."""


@pytest.mark.parametrize(
    ("cls", "name", "value", "needs"),
    [
        (ArticulationCfg, "class_type", None, "null; it needs a class"),
        (ArticulationCfg, "class_type", len, "it needs a class"),
        (ArticulationCfg, "actuators", [1], "it needs a dictionary"),
        (ArticulationCfg, "actuators", {"arm": None}, "x.arm is null; it needs a ActuatorBaseCfg"),
        (CuboidCfg, "rigid_props", 5, "it needs a RigidBodyPropertiesCfg"),
        (CuboidCfg, "semantic_tags", 5, "it needs a list"),
        (ObservationTermCfg, "noise", (0, 1), "it needs a NoiseCfg or NoiseModelCfg"),
        (RslRlPpoAlgorithmCfg, "rnd_cfg", "yes", "it needs a RslRlRndCfg"),
        (RewardTermCfg, "params", "weight", "it needs a dictionary"),
        (ManagerBasedRLEnvCfg, "scene", NUMBER, "it needs a InteractiveSceneCfg"),
        (ManagerBasedRLEnvCfg, "rewards", NUMBER, "it needs a configuration"),
        (ArticulationCfg, "init_state", NUMBER, "it needs a InitialStateCfg"),
        (VisualizationMarkersCfg, "markers", {"frame": NUMBER}, "x.frame is 5; it needs a SpawnerCfg"),
    ],
)
def test_what_cannot_be_meant_is_named(cls, name, value, needs):
    assert needs in kind_problem(cls, name, "x", value)


@configclass
class SameAnnotationCfg(mdp.UniformPoseCommandCfg):
    """Sets a field's default, as a user's command does."""

    class_type: type = MyArticulation


@configclass
class OtherAnnotationCfg(mdp.UniformPoseCommandCfg):
    """Means something else by a field."""

    class_type: type | int = 5


def test_a_users_sub_class_keeps_the_kind_unless_it_annotates_otherwise():
    assert kind_problem(SameAnnotationCfg, "class_type", "x", None) == "x is null; it needs a class"
    assert kind_problem(SameAnnotationCfg, "class_type", "x", MyArticulation) is None
    assert kind_problem(OtherAnnotationCfg, "class_type", "x", 7) is None


@pytest.mark.parametrize("name", ["scene", "sim", "viewer"])
def test_what_an_environment_needs_may_not_be_null(name):
    assert not may_be_none(ManagerBasedRLEnvCfg, name)


@pytest.mark.parametrize(
    ("cls", "name", "value"),
    [
        (ArticulationCfg, "class_type", MyArticulation),
        (ArticulationCfg, "class_type", "{DIR}.articulation:Articulation"),
        (ArticulationCfg, "actuators", {}),
        (CuboidCfg, "rigid_props", None),
        (CuboidCfg, "rigid_props", {"disable_gravity": True}),
        (ObservationTermCfg, "noise", GaussianNoiseCfg(mean=0.0, std=0.0)),
        (ObservationTermCfg, "scale", 2),
        (ObservationTermCfg, "scale", (2.0, 1.0)),
        (SimulationCfg, "gravity", [0, 0, -9.81]),
        (TerrainImporterCfg, "terrain_generator", None),
        (RewardTermCfg, "func", "module:name"),
    ],
)
def test_what_can_be_meant_is_taken(cls, name, value):
    assert kind_problem(cls, name, "x", value) is None


@pytest.mark.parametrize(
    ("cfg", "says"),
    [
        (SimulationCfg(gravity=(0.0, 0.0, NULL)), r"gravity\[2\] is null"),
        (
            CARTPOLE_CFG.replace(
                prim_path="/World/robot", init_state=ArticulationCfg.InitialStateCfg(joint_pos={"a": NULL})
            ),
            "joint_pos.a is null",
        ),
        (ObservationTermCfg(func=mdp.joint_pos_rel, clip=NUMBER), r"clip is 5; it needs two numbers, \(low, high\)"),
        (CuboidCfg(size=(1.0, 1.0, 1.0), collision_props=NUMBER), "needs a CollisionPropertiesCfg"),
    ],
)
def test_validate_names_it(cfg, says):
    with pytest.raises(ConfigError, match=says):
        cfg.validate()


def test_an_argument_is_null_only_if_its_annotation_says_so():
    gains = {"stiffness_distribution_params": None, "damping_distribution_params": (0.5, 2.0)}
    assert first_problem(EventTermCfg(func=mdp.randomize_actuator_gains, mode="reset", params=gains)) is None
    ranges = {"position_range": None, "velocity_range": (0.0, 0.0)}
    problem = first_problem(EventTermCfg(func=mdp.reset_joints_by_offset, mode="reset", params=ranges), "e")
    assert problem == "e.params.position_range is null; it must be finite"


@pytest.mark.parametrize(
    "cfg",
    [
        ObservationTermCfg(func=mdp.joint_pos_rel, clip=(NULL, 1.0)),
        UsdFileCfg(usd_path="a.usda", scale=np.float64(0.8)),  # type: ignore[arg-type]
        SimulationCfg(dt=np.float32(0.01), gravity=np.array([0.0, 0.0, -9.81])),  # type: ignore[arg-type]
    ],
)
def test_odd_values_that_work_are_taken(cfg):
    assert first_problem(cfg) is None
