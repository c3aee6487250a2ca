"""One command trains, evaluates and reports, and goes on where it was."""

import json
import runpy
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[2] / "scripts" / "rsl_rl"


@pytest.fixture
def study(monkeypatch, tmp_path, capfd):
    """Runs the study in a folder of its own; returns exit status, output and errors."""
    monkeypatch.chdir(tmp_path)

    def call(*args):
        monkeypatch.setattr(sys, "argv", ["study.py", *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(SCRIPTS / "study.py"), run_name="__main__")
        return ended.value.code, *capfd.readouterr()

    return call


@pytest.mark.slow
def test_a_study_trains_evaluates_and_reports_and_goes_on_where_it_was(study, tmp_path):
    flags = ["--tasks", "short-CL=Lift-Cube-Franka-CL env.episode_length_s=0.4", "--seeds", 3, "--name", "tiny"]
    flags += ["--num_envs", 8, "--episodes", 8, "--num_threads", 1, "--device", "cpu"]
    folder = tmp_path / "logs" / "rsl_rl" / "tiny"

    status, out, err = study(*flags, "--max_iterations", 1, "--no_report")
    assert (status, err) == (0, "")
    (run,) = json.loads((folder / "results.json").read_text())["runs"]
    assert (run["label"], run["seed"], run["iterations"], run["status"]) == ("short-CL", 3, 1, "done")
    assert run["evaluation"]["episodes"] == 8
    assert run["evaluation"]["mean_episode_length"] <= 20

    status, out, _ = study(*flags, "--max_iterations", 2, "--perturb", "mass=2.0")
    assert status == 0
    assert "--resume" in out
    (run,) = json.loads((folder / "results.json").read_text())["runs"]
    assert run["iterations"] == 2
    assert run["perturbed"]["mass=2.0"]["perturb"] == ["mass=2.0"]
    page = (folder / "report" / "report.html").read_text()
    for title in ("Table 1", "Success under perturbations", "End of training", "short-CL"):
        assert title in page

    status, out, _ = study(*flags, "--max_iterations", 2, "--no_report")
    assert status == 0
    assert ": train --" not in out  # all of it is done

    branch = [flags[0], "base=Lift-Cube-Franka env.episode_length_s=0.4 from=short-CL@1", *flags[2:]]
    status, out, err = study(*branch, "--max_iterations", 2)
    assert (status, err) == (0, "")
    assert "model_1.pt" in out  # the first piece of the curriculum's training
    runs = {run["label"]: run for run in json.loads((folder / "results.json").read_text())["runs"]}
    assert (runs["base"]["iterations"], runs["base"]["status"]) == (2, "done")
    assert "base" in (folder / "report" / "report.html").read_text()

    status, _, err = study(*flags, "--max_iterations", 2, "agent.algorithm.gamma=0.9")
    assert status == 2
    assert "take another --name" in err


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--tasks", "Lift-Cube-Frank"], "did you mean"),
        (["--perturb", "mas=2"], "did you mean 'mass'"),
        (["--tasks", "x=Lift-Cube-Franka env.nothing=1"], "nothing"),
        (["--tasks", "Lift-Cube-Franka from=Lift-Cube-Franka-CM@2", "Lift-Cube-Franka-CL"], "did you mean 'Lift-Cube-"),
        (["--seeds", "1", "1", "env.scene.num_envs=8"], "seed '1' is given twice"),
        (["--seed", "1"], "did you mean --seeds"),
        (["--seeds", "-1"], "argument --seeds: expected a whole number from 0"),
        (["--name", ""], "'' cannot be a folder's name"),
        (["--name", ".."], "'..' cannot be a folder's name"),
        (["--name", "a=b"], "'a=b' cannot be a folder's name"),
        (["--tasks", "Cartpole", "--perturb", "mass=2"], "this task has no 'object' to perturb"),
        (["--perturb", "delay=0.007"], "multiple of the physics step"),
        (["--device", "cuda:77"], "'cuda:77' is not available"),
        (["--tasks", "Lift-Cube-Franka-CL", "Lift-Cube-Franka from=Lift-Cube-Franka-CL@770"], "saves every 50"),
        (["agent.seed=3"], "'agent.seed=3': agent.seed of a study is set by --seeds and --eval_seed"),
        (["--tasks", "x=Cartpole env.seed=3"], "env.seed of a study is set by --seeds"),
        (["agent.run_name=x"], "set by the tasks' labels"),
        (["agent.resume=true"], "set by the study"),
        (["--processes", "2", "env.sim.num_threads=99"], "and env.sim.num_threads=99: give one of them"),
        (["--num_envs", "8", "env.scene.num_envs=9"], "--num_envs 8 and env.scene.num_envs=9: give one of them"),
        (["--max_iterations", "8", "agent.max_iterations=9"], "give one of them"),
        (["--perturb_episodes", "8"], "--perturb_episodes counts the episodes under each perturbation: add --perturb"),
        (["-m", "agent.algorithm.gamma=0.98,0.99"], "unknown flag '-m'"),
    ],
)
def test_a_mistake_ends_the_study_before_its_first_training(study, tmp_path, flags, message):
    status, _, err = study(*flags)
    assert status == 2
    assert message in err
    assert err.count("\n") == 1
    assert not (tmp_path / "logs").exists()
