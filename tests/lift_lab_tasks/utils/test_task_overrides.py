"""Tasks are found by id, and overrides change exactly what they name or end with the nearest names."""

import os
import sys
from types import ModuleType

import gymnasium as gym
import pytest

from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError, FileError, NotFoundError
from lift_lab_tasks.utils import get_checkpoint_path, load_cfg_from_registry, registered_tasks
from lift_lab_tasks.utils.hydra import compose, hydra_task_config


def lifted(env):
    return env


def reached(env):
    return env


@configclass
class TermCfg:
    func = lifted
    weight: float = 1.0
    params: dict = {"std": 0.1}


@configclass
class RewardsCfg:
    lifting_object = TermCfg(weight=15.0)
    reaching_object = TermCfg(func=reached)


@configclass
class CurriculumCfg:
    joint_vel = TermCfg(weight=-0.1)
    action_rate = TermCfg(weight=-0.1)


@configclass
class LinearCurriculumCfg(CurriculumCfg):
    joint_vel = TermCfg(weight=-0.5)


@configclass
class SceneCfg:
    num_envs: int = 4096
    name: str = "scene"


@configclass
class SimCfg:
    device: str = "cpu"
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)


@configclass
class EnvCfg:
    decimation: int = 4
    scene = SceneCfg()
    sim = SimCfg()
    rewards = RewardsCfg()
    curriculum = CurriculumCfg()
    names: list[str] = ["a", "b"]
    seed: int | None = None


@configclass
class MirrorLossCfg:
    coef: float = 0.0
    augment: bool = False


@configclass
class AgentCfg:
    max_iterations: int = 100
    mirror_loss: MirrorLossCfg | None = None
    gamma: float = 0.98


@pytest.fixture(autouse=True)
def task():
    module = ModuleType("fake_task_configs")
    module.EnvCfg, module.AgentCfg, module.LinearCurriculumCfg = EnvCfg, AgentCfg, LinearCurriculumCfg
    module.reached = reached
    sys.modules[module.__name__] = module
    gym.register(
        id="Fake-Lift",
        entry_point="lift_lab.envs:ManagerBasedRLEnv",
        disable_env_checker=True,
        kwargs={
            "env_cfg_entry_point": "fake_task_configs:EnvCfg",
            "rsl_rl_cfg_entry_point": "fake_task_configs:AgentCfg",
            "presets": {"env.curriculum": {"linear": "fake_task_configs:LinearCurriculumCfg"}},
        },
    )
    yield "Fake-Lift"
    del gym.registry["Fake-Lift"], sys.modules[module.__name__]


def overridden(*overrides):
    return compose("Fake-Lift", "rsl_rl_cfg_entry_point", overrides)


def check_one_line(call, message):
    with pytest.raises(ConfigError) as caught:
        call()
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_overrides_change_what_they_name_and_nothing_else():
    env, agent = overridden("env.rewards.lifting_object.weight=20", "agent.gamma=0.9")
    assert env.rewards.lifting_object.weight == 20.0
    assert isinstance(env.rewards.lifting_object.weight, float)
    assert agent.gamma == 0.9
    expected = EnvCfg()
    expected.rewards.lifting_object.weight = 20.0
    assert env.to_dict() == expected.to_dict()
    assert env.rewards.lifting_object.func is lifted


def test_null_leaves_a_term_out():
    env, _ = overridden("env.curriculum.joint_vel=null")
    assert env.curriculum.joint_vel is None
    assert env.curriculum.action_rate.weight == -0.1


def test_tuples_stay_tuples_and_lists_stay_lists():
    env, _ = overridden("env.sim.gravity=[0,0,-1]", "env.names=[x,y,z]")
    assert env.sim.gravity == (0.0, 0.0, -1.0)
    assert isinstance(env.sim.gravity, tuple)
    assert env.names == ["x", "y", "z"]


def test_a_dictionary_sets_each_of_its_entries():
    env, _ = overridden("env.rewards.lifting_object={weight:3,params:{std:0.5}}")
    assert env.rewards.lifting_object.weight == 3.0
    assert env.rewards.lifting_object.params == {"std": 0.5}
    assert env.rewards.lifting_object.func is lifted


def test_entries_are_added_to_and_removed_from_dictionaries_only():
    env, _ = overridden("+env.rewards.lifting_object.params.height=0.04", "~env.rewards.reaching_object.params.std")
    assert env.rewards.lifting_object.params == {"std": 0.1, "height": 0.04}
    assert env.rewards.reaching_object.params == {}
    with pytest.raises(ConfigError, match=r"unknown override key 'env\.rewards\.extra'"):
        overridden("+env.rewards.extra=1")


def test_functions_are_given_by_module_and_name():
    env, _ = overridden("env.rewards.lifting_object.func='fake_task_configs:reached'")
    assert env.rewards.lifting_object.func is reached
    with pytest.raises(ConfigError, match="reachd"):
        overridden("env.rewards.lifting_object.func='fake_task_configs:reachd'")


def test_values_may_refer_to_each_other():
    env, agent = overridden("agent.max_iterations=7", "env.decimation=${agent.max_iterations}")
    assert env.decimation == agent.max_iterations == 7


def test_presets_replace_a_group_before_single_overrides():
    env, _ = overridden("env.curriculum.action_rate=null", "env/curriculum=linear")
    assert env.curriculum.joint_vel.weight == -0.5
    assert env.curriculum.action_rate is None


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (
            "env.rewards.lifting_objct.weight=20",
            "unknown override key 'env.rewards.lifting_objct.weight'; did you mean 'env.rewards.lifting_object.weight'",
        ),
        ("env.rewards.lifting_object.wieght=20", "did you mean 'env.rewards.lifting_object.weight'?"),
        ("rewards.lifting_object.weight=20", "did you mean 'env.rewards.lifting_object.weight'?"),
        ("agnt.gamma=1", "did you mean 'agent.gamma'?"),
        ("env.decimation=fast", "env.decimation: expected int, got str 'fast'"),
        ("env.decimation=1.5", "env.decimation: expected int, got float 1.5"),
        ("env.decimation=null", "env.decimation needs a int, not null"),
        ("env.sim.gravity=[0,0]", "env.sim.gravity"),
        ("env.rewards.lifting_object=5", "env.rewards.lifting_object is a TermCfg; set one of"),
        ("env.decimation=1,2", "lists several values: add --multirun"),
        ("env.names=[a", "cannot read the override 'env.names=[a'"),
        ("hydra.run.dir=x", "hydra's own settings"),
        ("env/curiculum=linear", "no presets for 'env/curiculum'; did you mean 'env/curriculum'?"),
        ("env/curriculum=linear,none", "lists several values: add --multirun"),
        ("env/curriculum=liner", "no preset 'liner' for 'env/curriculum'; did you mean 'linear'?"),
        ("stray", "unexpected argument 'stray'"),
    ],
)
def test_a_wrong_override_is_answered_in_one_line(override, message):
    check_one_line(lambda: overridden(override), message)


def test_a_null_default_takes_a_value_and_null_again():
    assert overridden("env.seed=3")[0].seed == 3
    assert overridden("env.seed=3", "env.seed=null")[0].seed is None


def test_an_entry_below_null_makes_the_configuration_that_the_annotation_names():
    _, agent = overridden("agent.mirror_loss.coef=0.5")
    assert agent.mirror_loss.to_dict() == {"coef": 0.5, "augment": False}
    assert overridden("agent.mirror_loss={augment:true}")[1].mirror_loss.augment is True
    assert overridden("agent.gamma=0.9")[1].mirror_loss is None
    check_one_line(lambda: overridden("agent.mirror_loss.cof=1"), "did you mean 'agent.mirror_loss.coef'?")


def test_nothing_is_written_and_no_directory_entered(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    overridden("env.decimation=2")
    assert os.getcwd() == str(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_the_decorator_reads_the_command_line(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["train.py", "env.decimation=9"])

    @hydra_task_config("Fake-Lift", "rsl_rl_cfg_entry_point")
    def main(env_cfg, agent_cfg, extra):
        return env_cfg.decimation, agent_cfg.max_iterations, extra

    assert main("x") == (9, 100, "x")


def test_the_decorator_runs_through_what_overrides_list(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["train.py", "--multirun", "env.decimation=2,3", "agent.gamma=0.5"])

    @hydra_task_config("Fake-Lift", "rsl_rl_cfg_entry_point")
    def main(env_cfg, agent_cfg):
        return env_cfg.decimation, agent_cfg.gamma

    assert main() == [(2, 0.5), (3, 0.5)]


def test_an_unknown_task_or_agent_is_answered_with_the_nearest():
    assert "Fake-Lift" in registered_tasks()
    with pytest.raises(NotFoundError, match="unknown task 'Fake-Lft'; did you mean 'Fake-Lift'"):
        load_cfg_from_registry("Fake-Lft", "env_cfg_entry_point")
    with pytest.raises(NotFoundError, match="did you mean 'rsl_rl_cfg_entry_point'"):
        load_cfg_from_registry("Fake-Lift", "rsl_cfg_entry_point")


def test_the_newest_checkpoint_of_the_newest_run_that_has_one_is_found(tmp_path):
    for run, names in {
        "2026-01-01": ["model_9.pt", "model_10.pt", "model_best.pt", "resume_state_10.pt"],
        "2026-01-02": ["model_5.pt"],
        "2026-01-03": [],
    }.items():
        (tmp_path / run).mkdir()
        for name in names:
            (tmp_path / run / name).touch()
    assert get_checkpoint_path(tmp_path).endswith("2026-01-02/model_5.pt")
    assert get_checkpoint_path(tmp_path, ".*01-01").endswith("2026-01-01/model_10.pt")
    assert get_checkpoint_path(tmp_path, checkpoint="model_best.pt").endswith("2026-01-01/model_best.pt")
    with pytest.raises(FileError, match=r"did you mean 'model_9\.pt'"):
        get_checkpoint_path(tmp_path, ".*01-01", "model_99.pt")
    with pytest.raises(FileError, match="no run in"):
        get_checkpoint_path(tmp_path, "2027.*")
    with pytest.raises(FileError, match="train first"):
        get_checkpoint_path(tmp_path / "absent")
    with pytest.raises(ConfigError, match="not a regular expression"):
        get_checkpoint_path(tmp_path, "(")


def lift(*overrides):
    import lift_lab_tasks  # noqa: F401

    return compose("Lift-Cube-Franka", None, overrides)[0]


def test_a_joint_name_pattern_may_be_a_key():
    env = lift(
        "env.scene.robot.init_state.joint_pos={panda_finger_joint.*:0.02}",
        "env.actions.gripper_action.open_command_expr={panda_finger_.*:0.03}",
    )
    assert env.scene.robot.init_state.joint_pos["panda_finger_joint.*"] == 0.02
    assert (
        env.scene.robot.init_state.joint_pos["panda_joint2"] == lift().scene.robot.init_state.joint_pos["panda_joint2"]
    )
    assert env.actions.gripper_action.open_command_expr == {"panda_finger_.*": 0.03}


def test_a_dictionary_takes_the_place_of_a_number_where_the_annotation_allows_it():
    env = lift("env.actions.arm_action.scale={panda_joint1:0.5,panda_joint2:0.25}")
    assert env.actions.arm_action.scale == {"panda_joint1": 0.5, "panda_joint2": 0.25}
    with pytest.raises(ConfigError, match=r"env\.decimation: expected int"):
        lift("env.decimation={a:1}")


def test_an_empty_dictionary_takes_new_entries():
    name = "env.events.reset_object_position.params.velocity_range"
    assert lift().events.reset_object_position.params["velocity_range"] == {}
    assert lift(f"{name}={{x:[-1,1]}}").events.reset_object_position.params["velocity_range"] == {"x": [-1, 1]}


def test_entries_of_a_list_of_configurations_are_numbered():
    env = lift("env.scene.ee_frame.target_frames.0.offset.pos=[0,0,0.2]")
    assert tuple(env.scene.ee_frame.target_frames[0].offset.pos) == (0.0, 0.0, 0.2)
    for wrong, message in (("9.name=x", "unknown override key"), ("0=null", "an entry of a list is not replaced")):
        with pytest.raises(ConfigError, match=message):
            lift(f"env.scene.ee_frame.target_frames.{wrong}")


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("env.rewards.lifting_object={weigth:3}", "did you mean 'env.rewards.lifting_object.weight'?"),
        ("env.seed=abc", "env.seed: expected int, got str 'abc'"),
        ("env.sim.num_threads=abc", "env.sim.num_threads: expected int, got str 'abc'"),
        ("env.sim.mujoco.nconmax=20.5", "env.sim.mujoco.nconmax: expected int, got float 20.5"),
        ("~env", "only entries below env can be changed or removed"),
        ("env=3", "only entries below env can be changed or removed"),
    ],
)
def test_a_wrong_override_of_a_real_task_is_answered_in_one_line(override, message):
    check_one_line(lambda: lift(override), message)
