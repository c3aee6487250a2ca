"""A new learning library is one class: the programs do all that libraries have in common."""

import importlib
import re
import signal
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pytest
import torch

import lift_lab_tasks  # noqa: F401
from lift_lab.app import endings
from lift_lab.utils.errors import ConfigError, NotFoundError
from lift_lab.utils.io import dump_yaml, load_yaml
from lift_lab_cli import play, train
from lift_lab_cli.library import find_library, until_interrupted

PAGE = Path(__file__).parents[2] / "docs" / "libraries.md"


@pytest.fixture(scope="module")
def constant(tmp_path_factory):
    """The library that the documentation shows, as a module of its user."""
    (code,) = re.findall(r"^```python\n(import torch\n.*?)^```$", PAGE.read_text(), flags=re.DOTALL | re.MULTILINE)
    folder = tmp_path_factory.mktemp("library")
    (folder / "constant.py").write_text(code)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(folder))
        yield importlib.import_module("constant").Constant
    del sys.modules["constant"]


@pytest.fixture
def call(tmp_path, monkeypatch, capsys):
    """Calls a program in a folder of its own; returns its exit status and what it printed."""
    monkeypatch.chdir(tmp_path)
    dump_yaml(tmp_path / "constant.yaml", {"seed": 7, "max_iterations": 5, "action": 0.5})
    monkeypatch.setitem(gym.registry["Cartpole"].kwargs, "constant_cfg_entry_point", str(tmp_path / "constant.yaml"))
    threads = torch.get_num_threads()

    def run(program, *args, library=None):
        flags = ["--task", "Cartpole", "--device", "cpu", "--num_envs", "3", *args]
        monkeypatch.setattr(sys, "argv", [f"{program.__name__}.py", *flags])
        status = program.main(library)
        return status, capsys.readouterr().out

    yield run
    torch.set_num_threads(threads)


def test_a_library_in_one_class_trains_and_plays(call, constant, tmp_path):
    status, out = call(train, "--max_iterations", "2", "--run_name", "a", "env.episode_length_s=3", library=constant())
    assert status == 0
    (folder,) = (tmp_path / "logs" / "constant" / "Cartpole").iterdir()
    assert folder.name.endswith("_a")
    assert f"finished after 5 steps: {folder / 'model.pt'}" in out
    assert "Cartpole: 3 environments on cpu, seed 7" in out
    params = {path.stem: load_yaml(path) for path in (folder / "params").iterdir()}
    assert params["run"] == {"task": "Cartpole", "overrides": ["env.episode_length_s=3"]}
    assert params["agent"] == {"seed": 7, "max_iterations": 2, "action": 0.5}
    assert (params["env"]["seed"], params["env"]["scene"]["num_envs"]) == (7, 3)
    status, out = call(play, "--steps", "4", library=constant())
    assert status == 0
    assert f"policy: {folder / 'model.pt'}\n4 steps of 3 environments, 0 episodes ended\n" in out


def test_the_command_line_names_a_library_of_its_user(call, constant):
    status, out = call(train, "--library", "constant:Constant", "--seed", "3")
    assert status == 0
    assert "finished after 5 steps" in out
    assert "seed 3" in out


def test_a_number_that_is_nan_is_refused(call, constant, tmp_path):
    with pytest.raises(ConfigError, match=r"agent\.action is nan"):
        call(train, "agent.action=nan", library=constant())
    assert [path.name for path in tmp_path.iterdir()] == ["constant.yaml"]


def test_a_training_that_is_refused_leaves_no_folder(call, constant, tmp_path, monkeypatch):
    def refuse(self, env, run):
        (run.folder / "events.out.tfevents").touch()
        raise NotFoundError("no")

    monkeypatch.setattr(constant, "training", refuse)
    with pytest.raises(NotFoundError):
        call(train, library=constant())
    assert [path.name for path in tmp_path.iterdir()] == ["constant.yaml"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("sb", "no library 'sb'; did you mean 'sb3'?"),
        ("xyz", "no library 'xyz'; choose one of: 'rsl_rl', 'sb3', 'skrl', 'module:Class'"),
        (
            "lift_lab_cli.librar:X",
            "no module 'lift_lab_cli.librar' in the package 'lift_lab_cli'; did you mean 'library'",
        ),
        ("lift_lab_cli.library:Libary", "'lift_lab_cli.library' has no 'Libary'; did you mean 'Library'"),
    ],
)
def test_an_unknown_library_is_answered_with_the_nearest(name, message):
    with pytest.raises(NotFoundError) as caught:
        find_library(name)
    assert message in str(caught.value)


def test_a_library_in_the_current_folder_is_found(tmp_path, monkeypatch):
    (tmp_path / "own_library.py").write_text("class Own:\n    name = 'own'\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [entry for entry in sys.path if entry not in ("", str(tmp_path))])
    assert find_library("own_library:Own").name == "own"
    del sys.modules["own_library"]


def interrupt():
    raise KeyboardInterrupt


def fail():
    raise ValueError("a bug")


def test_ctrl_c_ends_a_training_early_and_a_bug_stays_one():
    assert until_interrupted(lambda: None) is None
    assert until_interrupted(interrupt) == signal.SIGINT
    with endings.handled():
        assert until_interrupted(lambda: signal.raise_signal(signal.SIGTERM)) == signal.SIGTERM
    with pytest.raises(ValueError, match="a bug"):
        until_interrupted(fail)


def test_help_needs_neither_torch_nor_a_library():
    code = (
        "import sys, lift_lab_cli.sb3_library, lift_lab_cli.skrl_library, lift_lab_cli.train, lift_lab_cli.play, "
        "lift_lab_cli.study, lift_lab_cli.report, lift_lab_cli.evaluate, lift_lab_cli.list_envs, lift_lab_cli.watch; "
        "print([m for m in ('torch', 'gymnasium', 'rsl_rl', 'skrl', 'stable_baselines3') if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"
