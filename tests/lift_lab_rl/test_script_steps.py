"""What the scripts of all learning libraries share says and writes the same for each."""

import signal
from types import SimpleNamespace

import pytest

from lift_lab.app import endings
from lift_lab.utils.io import load_yaml
from lift_lab_rl.script_steps import film_training, print_played, print_videos, until_interrupted, write_configurations


def interrupt():
    raise KeyboardInterrupt


def fail():
    raise ValueError("a bug")


def test_ctrl_c_ends_a_training_early_and_a_bug_stays_one():
    assert until_interrupted(lambda: None) == ("finished", 0)
    assert until_interrupted(interrupt) == ("ended early", 130)
    with endings.handled():
        assert until_interrupted(lambda: signal.raise_signal(signal.SIGTERM)) == ("ended early", 143)
    with pytest.raises(ValueError, match="a bug"):
        until_interrupted(fail)


def test_the_mean_reward_is_told_per_second_of_an_environment(capsys):
    env = SimpleNamespace(unwrapped=SimpleNamespace(num_envs=3, step_dt=0.02))
    print_played(env, steps=50, episodes=4, reward=2.5)  # 50 steps take 1 s
    assert capsys.readouterr().out == "50 steps of 3 environments, 4 episodes ended\nmean reward: 2.500 per second\n"


def test_what_a_run_is_made_of_lies_beside_it(tmp_path):
    write_configurations(tmp_path / "run", "Cartpole", {"a": 1}, {"seed": 2}, ("env.a=1",))
    found = {path.name: load_yaml(path) for path in (tmp_path / "run" / "params").iterdir()}
    run = {"task": "Cartpole", "overrides": ["env.a=1"]}
    assert found == {"env.yaml": {"a": 1}, "agent.yaml": {"seed": 2}, "run.yaml": run}
    write_configurations(tmp_path / "next", "Cartpole", {}, {}, ("env.a=1",), tmp_path / "run" / "model_5.pt")
    assert load_yaml(tmp_path / "next" / "params" / "run.yaml") == run | {"continues": "run/model_5.pt"}


def test_without_the_flag_an_environment_is_not_filmed(tmp_path, capsys):
    env = SimpleNamespace()
    assert film_training(env, SimpleNamespace(video=False), tmp_path) is env
    print_videos(env)
    assert capsys.readouterr().out == ""
