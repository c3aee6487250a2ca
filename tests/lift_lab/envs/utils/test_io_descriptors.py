"""Descriptions of what a policy reads and drives: Isaac Lab's keys, and the values of the environment."""

import numpy as np
import pytest
import torch
import yaml
from env_parts import group_of

import lift_lab.envs.mdp as mdp
from lift_lab.envs.utils.io_descriptors import generic_io_descriptor, record_joint_names, record_shape
from lift_lab.managers import ManagerTermBase, ObservationTermCfg, SceneEntityCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.io_descriptors import plain
from lift_lab.utils.modifiers import ModifierCfg, scale

OBSERVATION_KEYS = {"name", "mdp_type", "full_path", "shape", "dtype", "observation_type", "overloads", "extras"}
"""What every entry of Isaac Lab 2.3.2's file has."""
ACTION_KEYS = {"name", "mdp_type", "full_path", "shape", "dtype", "action_type", "extras"}


@generic_io_descriptor(units="turns", observation_type="Mine", on_inspect=[record_shape, record_joint_names])
def turns(env, asset_cfg=SceneEntityCfg("robot"), factor=1.0):
    """Positions in
    turns."""
    return env.scene[asset_cfg.name].data.joint_pos[:, asset_cfg.joint_ids] * factor / (2.0 * torch.pi)


class Counting(ManagerTermBase):
    """Counts its calls."""

    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self.calls = 0

    def __call__(self, env):
        self.calls += 1
        return torch.full((env.num_envs, 2), float(self.calls))


ELBOW = SceneEntityCfg("robot", joint_names=["elbow"])
TERMS = {
    "angle": ObservationTermCfg(func=mdp.joint_pos_rel, scale=0.5, clip=(-1.0, 1.0), history_length=3),
    "elbow": ObservationTermCfg(func=turns, params={"asset_cfg": ELBOW}, scale=(2.0,)),
    "calls": ObservationTermCfg(func=Counting),
    "fast": ObservationTermCfg(func=mdp.joint_vel_rel, modifiers=[ModifierCfg(func=scale, params={"multiplier": 3.0})]),
}


@pytest.mark.parametrize("physics", ["native", "warp"])
def test_the_file_holds_the_environments_values(make_env, tmp_path, physics):
    env = make_env(physics=physics, observations=group_of(**TERMS), log_dir=str(tmp_path), export_io_descriptors=True)
    found = yaml.safe_load((tmp_path / "io_descriptors" / "IO_descriptors.yaml").read_text())
    assert found == env.get_IO_descriptors
    assert set(found) == {"observations", "actions", "articulations", "scene"}
    assert found["scene"] == {"physics_dt": 0.005, "dt": 0.02, "decimation": 4}
    robot = found["articulations"]["robot"]
    names, values = robot["joint_names"], pytest.approx([0.3, -0.2])
    assert names == env.scene["robot"].joint_names == ["shoulder", "elbow"]
    assert robot["default_joint_pos"] == values
    assert robot["default_joint_stiffness"] == [50.0, 50.0]
    assert robot["default_joint_damping"] == [5.0, 5.0]
    lower, upper = -torch.pi / 2, 2 * torch.pi / 3  # of the file: -90 and 120 degrees
    assert robot["default_joint_pos_limits"] == [pytest.approx([lower, upper])] * 2
    (action,) = found["actions"]
    assert action.keys() >= ACTION_KEYS | {"joint_names", "scale", "offset", "clip"}
    assert (action["name"], action["action_type"]) == ("joint_position_action", "JointAction")
    assert (action["scale"], action["offset"], action["clip"]) == (0.5, values, None)
    angle, elbow, calls, fast = found["observations"]["policy"]
    assert all(entry.keys() >= OBSERVATION_KEYS for entry in (angle, elbow, calls, fast))
    assert (angle["name"], angle["shape"], angle["dtype"]) == ("joint_pos_rel", [2], "torch.float32")
    expected = {"scale": 0.5, "clip": [-1.0, 1.0], "history_length": 3, "flatten_history_dim": True}
    assert (angle["joint_pos_offsets"], angle["overloads"]) == (values, expected)
    assert (elbow["joint_names"], elbow["shape"], elbow["overloads"]["scale"]) == (["elbow"], [1], [2.0])
    assert (elbow["observation_type"], elbow["extras"]["units"]) == ("Mine", "turns")
    assert elbow["extras"]["description"] == "Positions in turns."
    assert (calls["name"], calls["shape"], calls["extras"]["description"]) == ("Counting", [2], "Counts its calls.")
    assert fast["extras"]["modifiers"][0]["params"] == {"multiplier": 3.0}


def test_to_describe_a_term_changes_no_state(make_env):
    env = make_env(observations=group_of(**TERMS))
    (term,) = env.observation_manager.term_objects().values()
    env.reset()
    calls = term.calls
    assert env.get_IO_descriptors == env.get_IO_descriptors
    assert term.calls == calls
    assert not any("descriptor" in key.lower() for key in str(env.state_dict()["objects"]).split("'"))


def test_an_action_class_of_a_users_own_adds_to_its_description(make_env, make_cfg):
    class Mine(mdp.JointPositionAction):
        """Mine."""

        @property
        def IO_descriptor(self):
            super().IO_descriptor  # noqa: B018 - as Isaac Lab's classes write it
            self._IO_descriptor.my_gain = torch.tensor([1.0, 2.0])
            return self._IO_descriptor

    class Hidden(Mine):
        """Not exported."""

        export_IO_descriptor = False

    cfg = make_cfg()
    cfg.actions.joints.class_type = Mine
    cfg.actions.other = mdp.JointPositionActionCfg(asset_name="robot", joint_names=["elbow"], class_type=Hidden)
    (found,) = make_env(cfg=cfg).get_IO_descriptors["actions"]
    assert (found["name"], found["my_gain"], found["extras"]["description"]) == ("mine", [1.0, 2.0], "Mine.")


def test_a_file_needs_a_folder(make_env, tmp_path):
    with pytest.raises(ConfigError, match=r"env\.log_dir"):
        make_env(export_io_descriptors=True)
    env = make_env()
    with pytest.raises(ConfigError, match=r"env\.log_dir"):
        env.export_IO_descriptors()
    assert env.export_IO_descriptors(tmp_path / "new").is_file()


def test_values_become_plain_data():
    class Node:
        def __init__(self):
            self.me = self

    @configclass
    class Cfg:
        func: object = mdp.joint_pos
        limits: tuple = (1, 2.5)

    values = {"t": torch.tensor([0.04]), 3: np.float32(0.1), "n": Node(), "c": Cfg(), "s": slice(None), "f": None}
    assert plain(values) == {
        "t": [0.04],
        "3": 0.1,
        "n": Node.__qualname__,
        "c": {"func": "lift_lab.envs.mdp.observations:joint_pos", "limits": [1, 2.5]},
        "s": "slice(None, None, None)",
        "f": None,
    }
