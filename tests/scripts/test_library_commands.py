"""The scripts for skrl and Stable-Baselines3 train, play and answer mistakes as rsl_rl's do."""

import importlib.util
import io
import zipfile

import pytest
import torch

SMALL = ["--task", "Cartpole", "--device", "cpu", "--num_threads", "1", "--num_envs", "8"]
PACKAGES = {"skrl": "skrl", "sb3": "stable_baselines3"}


def _needs(package, extra):
    missing = importlib.util.find_spec(package) is None
    return pytest.mark.skipif(missing, reason=f"{package} is not installed (the extra '{extra}')")


needs_sb3, needs_skrl = _needs("stable_baselines3", "sb3"), _needs("skrl", "skrl")


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """An empty current directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@needs_sb3
def test_sb3_trains_plays_and_starts_from_a_model(script, place):
    status, out, _ = script(
        "sb3/train.py", *SMALL, "--max_iterations", 2, "--run_name", "a", "--save_interval", 16, "agent.n_steps=16",
        "env.episode_length_s=0.1",
    )  # fmt: skip
    assert status == 0
    (run,) = (place / "logs" / "sb3" / "Cartpole").iterdir()
    assert run.name.endswith("_a")
    names = {path.name for path in run.iterdir()}
    assert {"model.zip", "model_128_steps.zip", "model_256_steps.zip", "params"} <= names
    assert {path.name for path in (run / "params").iterdir()} == {"agent.yaml", "env.yaml", "run.yaml"}
    assert any(name.startswith("events.out.tfevents") for name in names)
    assert "Episode_Reward/alive" in out or "alive" in out
    assert "finished after 256 samples" in out

    status, out, _ = script("sb3/play.py", *SMALL, "--steps", 3)
    assert status == 0
    assert str(run / "model.zip") in out
    assert "3 steps of 8 environments" in out
    status, out, _ = script("sb3/play.py", *SMALL, "--steps", 3, "--use_last_checkpoint")
    assert str(run / "model_256_steps.zip") in out

    status, _, _ = script("sb3/train.py", *SMALL, "--max_iterations", 1, "--checkpoint", run / "model.zip")
    assert status == 0
    assert {path.name for path in place.iterdir()} == {"logs"}


@needs_skrl
def test_skrl_trains_plays_and_starts_from_an_agent(script, place):
    more = ["agent.agent.experiment.write_interval=8", "agent.agent.experiment.checkpoint_interval=16"]
    status, out, _ = script("skrl/train.py", *SMALL, "--max_iterations", 2, "--run_name", "a", *more)
    assert status == 0
    (run,) = (place / "logs" / "skrl" / "Cartpole").iterdir()
    assert run.name.endswith("_ppo_torch_a")
    assert {path.name for path in (run / "checkpoints").iterdir()} >= {"agent_16.pt", "agent_32.pt"}
    assert {path.name for path in (run / "params").iterdir()} == {"agent.yaml", "env.yaml", "run.yaml"}
    assert any(path.name.startswith("events.out.tfevents") for path in run.iterdir())
    assert "finished after 32 environment steps" in out

    status, out, _ = script("skrl/play.py", *SMALL, "--steps", 3, "--use_last_checkpoint")
    assert status == 0
    assert str(run / "checkpoints" / "agent_32.pt") in out
    assert "3 steps of 8 environments" in out

    status, _, _ = script(
        "skrl/train.py", *SMALL, "--max_iterations", 1, "--checkpoint", run / "checkpoints" / "agent_16.pt"
    )
    assert status == 0
    assert {path.name for path in place.iterdir()} == {"logs"}


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--task", "Cartpol"], "unknown task 'Cartpol'; did you mean 'Cartpole'"),
        ([*SMALL, "--num_env", "4"], "unknown flag '--num_env'; did you mean --num_envs"),
        ([*SMALL, "env.rewards.aliv.weight=2"], "did you mean 'env.rewards.alive.weight'?"),
        ([*SMALL, "agent.sede=2"], "unknown override key 'agent.sede'; did you mean 'agent.seed'"),
        ([*SMALL, "agent.seed=1,2"], "add --multirun"),
        ([*SMALL, "--checkpoint", "nothing.zip"], "no checkpoint 'nothing.zip'"),
        (["--task", "Reach-Franka"], "_cfg_entry_point'"),
        ([*SMALL, "--agent", "rsl_rl_cfg_entry_point"], "this library reads dictionaries"),
    ],
)
@pytest.mark.parametrize("library", [pytest.param("sb3", marks=needs_sb3), pytest.param("skrl", marks=needs_skrl)])
def test_a_mistake_is_answered_in_one_line(script, place, library, args, message):
    status, _, err = script(f"{library}/train.py", *args)
    assert status == 2
    assert err.startswith("error: ")
    assert message in err
    assert err.count("\n") == 1
    assert list(place.iterdir()) == []


@pytest.mark.parametrize("library", [pytest.param("sb3", marks=needs_sb3), pytest.param("skrl", marks=needs_skrl)])
@pytest.mark.parametrize("command", ["train", "play"])
def test_files_of_another_library_and_files_that_run_code_are_refused_in_one_line(script, place, library, command):
    torch.save({"actor_state_dict": {}, "iter": 1}, place / "model_1.pt")
    status, _, err = script(f"{library}/{command}.py", *SMALL, "--checkpoint", place / "model_1.pt")
    assert (status, err.count("\n")) == (2, 1)
    assert "is a checkpoint of rsl_rl, not of" in err
    name, content = "agent_1.pt", {"policy": print, "optimizer": {}}
    if library == "sb3":
        name, buffer = "model_1.zip", io.BytesIO()
        torch.save(content, buffer)
        with zipfile.ZipFile(place / name, "w") as archive:
            archive.writestr("data", "{}")
            archive.writestr("policy.pth", buffer.getvalue())
    else:
        torch.save(content, place / name)
    status, _, err = script(f"{library}/{command}.py", *SMALL, "--checkpoint", place / name)
    assert (status, err.count("\n")) == (2, 1)
    assert "holds pickled Python objects (builtins.print): reading it runs code" in err
    status, _, err = script(f"{library}/{command}.py", *SMALL, "--checkpoint", place / name, "--trust")
    assert status == 2
    assert err.splitlines()[-1].startswith("error: ")  # skrl tells of the seed
    assert "does not fit this agent" in err
    assert {path.name for path in place.iterdir() if path.is_file()} == {"model_1.pt", name}
    assert not [path for path in place.rglob("*") if path.parent.name == "Cartpole"]  # no run


@pytest.mark.parametrize(
    ("script_name", "flags", "message"),
    [
        ("skrl/train.py", ["--ml_framework", "jax"], "skrl runs on torch here"),
        ("skrl/play.py", ["--algorithm", "MAPPO", "--ml_framework", "torch"], "the tasks have configurations of PPO"),
        ("sb3/play.py", ["--use_pretrained_checkpoint"], "the policies that ship are rsl_rl's"),
    ],
)
def test_flags_of_isaac_lab_that_ask_for_what_is_missing_are_refused(script, place, script_name, flags, message):
    status, _, err = script(script_name, *SMALL, *flags)
    assert (status, err.count("\n")) == (2, 1)
    assert err.startswith(f"error: {flags[0]}")
    assert message in err
    assert list(place.iterdir()) == []


@pytest.mark.parametrize("library", [pytest.param("sb3", marks=needs_sb3), pytest.param("skrl", marks=needs_skrl)])
def test_trust_without_a_checkpoint_is_refused(script, place, library):
    status, _, err = script(f"{library}/train.py", *SMALL, "--trust")
    assert status == 2
    assert "add --checkpoint" in err
    assert list(place.iterdir()) == []


@pytest.mark.parametrize("library", [pytest.param("sb3", marks=needs_sb3), pytest.param("skrl", marks=needs_skrl)])
def test_playing_without_a_run_says_to_train_first(script, library):
    status, _, err = script(f"{library}/play.py", *SMALL)
    assert status == 2
    assert "train first" in err


@pytest.mark.parametrize("library", ["sb3", "skrl"])
def test_a_missing_package_is_answered_with_the_extra_that_brings_it(script, monkeypatch, library):
    find, hidden = importlib.util.find_spec, PACKAGES[library]
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name == hidden else find(name, *a))
    status, _, err = script(f"{library}/train.py", *SMALL)
    assert status == 2
    assert err == f"error: this needs {PACKAGES[library]}: pip install 'lift-lab[{library}]'\n"
