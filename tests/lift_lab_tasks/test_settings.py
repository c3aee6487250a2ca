"""Flags and overrides of a command line make one set of settings, and each can be asked for."""

import pytest

import lift_lab_tasks  # noqa: F401
from lift_lab.app.cli import FlagSetting, Parser
from lift_lab.utils.errors import ConfigError
from lift_lab_cli.arguments import COMMON_SETTINGS
from lift_lab_tasks.settings import Settings
from lift_lab_tasks.utils.hydra import given_paths
from lift_lab_tasks.utils.runs import note_annealing

RSL_RL, SB3 = "rsl_rl_cfg_entry_point", "sb3_cfg_entry_point"


def settings(*overrides, agent=RSL_RL, task="Cartpole", training=False, **flags):
    """Settings of a task on the CPU, with flags by their names."""
    given = [
        FlagSetting(f"--{k}", path, v) for k, v in ({"device": "cpu"} | flags).items() for path in COMMON_SETTINGS[k]
    ]
    made = Settings(task, agent, overrides, given)
    made.resolve(training)
    return made


@pytest.mark.parametrize(
    ("override", "paths"),
    [
        ("env.scene.num_envs=4", {"env.scene.num_envs"}),
        ("+env.scene.num_envs=4", {"env.scene.num_envs"}),
        ("~env.curriculum.a", {"env.curriculum.a"}),
        ("env.scene={num_envs: 4}", {"env.scene", "env.scene.num_envs"}),
        ("env={scene:{num_envs:4},seed:1}", {"env", "env.scene", "env.scene.num_envs", "env.seed"}),
        ("env.scene={robot: {prim_path: /num_envs}}", {"env.scene", "env.scene.robot", "env.scene.robot.prim_path"}),
        ("env.names=[seed,scene]", {"env.names"}),
        ("env.scene='{num_envs: 4}'", {"env.scene"}),
        ("env/curriculum=linear", set()),
    ],
)
def test_an_override_gives_the_entries_that_it_sets_and_no_others(override, paths):
    assert given_paths([override]) == paths


def test_an_entry_is_given_by_a_flag_an_override_or_a_dictionary():
    made = settings("env.rewards.alive={weight: 2}", "env.episode_length_s=4", num_envs=3)
    for path in ("env.scene.num_envs", "env.rewards.alive", "env.rewards.alive.weight", "env.episode_length_s"):
        assert made.given(path)
    assert made.given("env.sim.device")
    assert not made.given("env.rewards")
    assert made.given("env.rewards", below=True)
    assert not made.given("env.reward", below=True)
    assert not made.given("env.seed")
    assert (made.env.scene.num_envs, made.env.rewards.alive.weight, made.env.episode_length_s) == (3, 2.0, 4.0)
    assert made.overrides == ["env.rewards.alive={weight: 2}", "env.episode_length_s=4"]


def test_an_override_may_refer_to_the_value_of_a_flag():
    assert settings("env.viewer.num_envs=${env.scene.num_envs}", num_envs=6).env.viewer.num_envs == 6


@pytest.mark.parametrize("agent", [RSL_RL, SB3])
def test_environment_and_agent_have_one_seed(agent):
    def seeds(*overrides, **flags):
        made = settings(*overrides, agent=agent, **flags)
        return made.env.seed, made.agent["seed"] if isinstance(made.agent, dict) else made.agent.seed

    assert seeds() == (42, 42)
    assert seeds("env.seed=3") == seeds("agent.seed=3") == seeds(seed=3) == (3, 3)
    assert seeds("env.seed=0") == seeds(seed=0) == (0, 0)
    assert seeds("env.seed=3", "agent.seed=3", seed=3) == (3, 3)
    drawn = seeds(seed=-1)
    assert drawn[0] == drawn[1] >= 0
    with pytest.raises(ConfigError, match=r"env\.seed=3 and agent\.seed=5: .* give one seed"):
        seeds("env.seed=3", "agent.seed=5")


@pytest.mark.parametrize(
    ("override", "flag", "message"),
    [
        ("agent.seed=5", {"seed": 3}, "--seed 3 and agent.seed=5: give one of them"),
        ("env.scene.num_envs=7", {"num_envs": 2}, "--num_envs 2 and env.scene.num_envs=7: give one of them"),
        ("env.scene={num_envs: 7}", {"num_envs": 2}, "--num_envs 2 and env.scene.num_envs=7: give one of them"),
        ("env.scene.num_envs=${env.decimation}", {"num_envs": 7}, "--num_envs 7 and env.scene.num_envs=2"),
        ("agent.device=cuda:0", {"device": "cpu"}, "--device cpu and agent.device=cuda:0: give one of them"),
    ],
)
def test_a_flag_and_an_override_of_one_entry_must_agree(override, flag, message):
    with pytest.raises(ConfigError) as caught:
        settings(override, **flag)
    assert message in str(caught.value)


def test_a_flag_that_depends_on_other_settings_is_checked_like_the_others():
    made = settings(agent=SB3)
    made.set("--max_iterations", "agent.n_timesteps", 96)
    assert made.agent["n_timesteps"] == 96
    made = settings("agent.n_timesteps=5", agent=SB3)
    with pytest.raises(ConfigError, match=r"--max_iterations 96 and agent\.n_timesteps=5: give one of them"):
        made.set("--max_iterations", "agent.n_timesteps", 96)


def test_as_many_environments_as_suit_the_device_unless_their_number_is_given():
    assert settings("env.scene.num_envs=5000").env.scene.num_envs == 5000
    made = Settings("Lift-Cube-Franka", None, [], [FlagSetting("--device", "env.sim.device", "cpu")])
    made.resolve()
    assert made.env.scene.num_envs == 512
    made = Settings("Lift-Cube-Franka", None, ["env.scene={num_envs: 9}"])
    made.resolve(num_envs=16)
    assert made.env.scene.num_envs == 9


def test_a_parser_tells_which_entries_its_flags_set():
    parser = Parser("Test.")
    for name, kind in (("seed", int), ("num_envs", int), ("run_name", str)):
        parser.add_argument(f"--{name}", type=kind, default=None)
    parser.add_argument("--quick", action="store_true")
    parser.settings |= {"seed": ("env.seed", "agent.seed"), "run_name": ("agent.run_name",), "quick": ("env.quick",)}
    args, _ = parser.parse(["--seed", "0", "--num_envs", "3"])
    assert args.flag_settings == [("--seed", "env.seed", 0), ("--seed", "agent.seed", 0)]


@pytest.mark.parametrize(
    ("overrides", "names"),
    [
        (["agent.algorithm.gamma=0.9"], ["gamma"]),
        (["agent.algorithm={gamma: 0.9, desired_kl: 0.02}"], ["gamma", "desired_kl"]),
        (["agent.algorithm.gamma=0.9", "agent.algorithm.gamma_final=null"], []),
        (["agent.algorithm.gamma=0.9", "agent.algorithm.gamma_final=0.99"], []),
        (["agent.algorithm.lam=0.9"], []),
    ],
)
def test_a_setting_that_changes_as_the_training_goes_on_says_so_where_it_is_given(overrides, names):
    made = Settings("Lift-Cube-Franka-CL", RSL_RL, overrides)
    agent_cfg = made.agent
    agent_cfg.algorithm.desired_kl_final = 0.005
    said: list[str] = []
    note_annealing(agent_cfg, made.given, said.append)
    assert [text.partition(" ")[0] for text in said] == [f"agent.algorithm.{name}" for name in names]
    if names == ["gamma"]:
        begin, end = agent_cfg.algorithm.anneal_iterations
        assert said[0].startswith(f"agent.algorithm.gamma is 0.9 at first and goes to 0.985 over iterations {begin} to")
        assert str(end) in said[0]
