"""What an exported policy says about itself."""

import json

import gymnasium as gym
import onnx
import pytest
import torch

import lift_lab
import lift_lab_tasks  # noqa: F401
from lift_lab_assets.files import PRETRAINED_DIR
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_tasks.settings import Settings

OVERRIDES = [
    *("env.sim.device=cpu", "env.seed=1", "env.observations.policy.joint_vel.scale=0.1"),
    *("env.observations.policy.joint_pos.clip=[-2.0,2.0]", "env.observations.policy.actions.history_length=3"),
    *("env.actions.arm_action.clip={panda_joint1: [-0.5,0.25]}", "agent.clip_actions=5.0"),
]


def no_constant(text):
    raise AssertionError(f"{text} is not JSON")


@pytest.fixture(scope="module")
def runner():
    settings = Settings("Lift-Cube-Franka", "rsl_rl_cfg_entry_point", OVERRIDES)
    settings.resolve(num_envs=2)
    made = gym.make("Lift-Cube-Franka", cfg=settings.env)
    env = RslRlVecEnvWrapper(made, clip_actions=settings.agent.clip_actions)
    yield LiftLabRunner(env, to_rsl_rl(settings.agent, env.get_observations().keys()), device="cpu")
    made.close()


@pytest.fixture(scope="module")
def folder(runner, tmp_path_factory):
    place = tmp_path_factory.mktemp("exported")
    runner.export_policy_to_onnx(str(place))
    runner.export_policy_to_jit(str(place))
    return place


@pytest.fixture(scope="module")
def texts(folder):
    return {prop.key: prop.value for prop in onnx.load(str(folder / "policy.onnx")).metadata_props}


@pytest.fixture(scope="module")
def values(texts):
    names = ("observations", "actions", "commands", "assets", "clip_actions", "is_recurrent", "step_dt", "decimation")
    return {name: json.loads(texts[name], parse_constant=no_constant) for name in names}


def test_observation_terms_are_the_networks_input_in_order(runner, texts, values):
    terms = values["observations"]
    assert [term["name"] for term in terms] == texts["observation_names"].split(",")
    starts = [sum(term["size"] for term in terms[:i]) for i in range(len(terms) + 1)]
    assert [term["start"] for term in terms] == starts[:-1]
    assert starts[-1] == runner.alg.get_policy().obs_dim == 9 + 9 + 3 + 7 + 3 * 8
    joint_pos, joint_vel, cube, goal, last = terms
    assert (joint_pos["function"], joint_pos["clip"], joint_pos["scale"]) == ("joint_pos_rel", [-2.0, 2.0], None)
    assert (joint_vel["scale"], joint_vel["joint_names"][:2]) == (0.1, ["panda_joint1", "panda_joint2"])
    assert cube["params"] == {"robot_cfg": {"name": "robot"}, "object_cfg": {"name": "object"}}
    assert goal["params"] == {"command_name": "object_pose"}
    assert (last["history_length"], last["shape"], last["size"]) == (3, [8], 24)


def test_action_terms_say_what_becomes_of_the_output(texts, values):
    arm, gripper = values["actions"]
    assert (arm["class"], arm["start"], arm["size"], arm["asset"]) == ("joint_position_action", 0, 7, "robot")
    assert (arm["scale"], arm["offset"]) == (0.5, [0.0, -0.569, 0.0, -2.81, 0.0, 3.037, 0.741])
    assert arm["clip"] == [[-0.5, 0.25]] + [[None, None]] * 6  # None: no limit
    assert (gripper["class"], gripper["start"], gripper["size"]) == ("binary_joint_position_action", 7, 1)
    assert (gripper["open_command"], gripper["close_command"]) == ([0.04, 0.04], [0.0, 0.0])
    assert gripper["closes_when"] == "action < 0"
    assert texts["action_scale"] == ",".join(["0.5"] * 7 + ["1.0"])
    assert texts["action_offset"] == "0.0,-0.569,0.0,-2.81,0.0,3.037,0.741,0.0"


def test_the_robot_has_the_keys_of_mjlabs_exporter(runner, texts, values):
    robot = runner.env.unwrapped.scene["robot"]
    assert texts["joint_names"].split(",") == robot.joint_names
    for key in ("default_joint_pos", "joint_stiffness", "joint_damping"):
        found = torch.tensor([float(number) for number in texts[key].split(",")])
        assert torch.equal(found, getattr(robot.data, key)[0])
    assert texts["command_names"] == "object_pose"
    assert values["assets"]["object"] == {"type": "rigid_object", "root_body": "object/Object"}
    assert all(group["is_implicit"] for group in values["assets"]["robot"]["actuators"].values())
    assert values["commands"][0]["ranges"]["pos_z"] == [0.25, 0.5]


def test_the_rest(texts, values):
    assert (values["step_dt"], values["decimation"], float(texts["physics_dt"])) == (0.02, 4, 0.005)
    assert (values["clip_actions"], values["is_recurrent"]) == (5.0, False)
    assert texts["task"] == "Lift-Cube-Franka"
    assert texts["lift_lab_version"] == lift_lab.__version__
    assert (texts["quaternion_order"], texts["observation_normalizer"], texts["format"]) == ("wxyz", "inside", "1")


def test_torchscript_holds_the_same(folder, texts):
    extra = {"metadata.json": ""}
    torch.jit.load(str(folder / "policy.pt"), _extra_files=extra)
    assert json.loads(extra["metadata.json"]) == texts


def test_the_checkpoint_is_named_without_its_folders(runner):
    found = runner.policy_metadata(PRETRAINED_DIR / "Lift-Cube-Franka" / "policy.pt")
    assert (found["run_path"], found["checkpoint"]) == ("Lift-Cube-Franka", "policy.pt")
    assert int(found["iteration"]) > 0
    assert not [key for key, value in found.items() if str(PRETRAINED_DIR.parent) in value]
