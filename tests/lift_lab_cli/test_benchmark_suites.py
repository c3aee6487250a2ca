"""The benchmark's suites measure what they say, keep what they have, and leave files that other programs can read."""

import json
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import torch

from lift_lab_cli.benchmark import suites as suites_module

SCRIPTS = Path(__file__).parents[2] / "scripts"


@pytest.fixture
def suites(monkeypatch):
    """The module of the suites; its measurements are made up: 100 steps/s and 1,000 bytes an environment."""

    def one(args, overrides, num_envs, steps, more=None, environ=None):
        if num_envs > 1000:
            return {"num_envs": num_envs, "error": "out of memory"}
        speed = {"env_steps_per_s": 100.0 * num_envs, "physics_steps_per_s": 500.0 * num_envs, "ratio": 0.8}
        memory = {"samples": [(64, 5), (128, 5)], "bytes_per_million_steps": 0.0}
        result = {"num_envs": num_envs, "decimation": 4, "env_memory_bytes": 1000 * num_envs, **speed}
        return result | ({"memory": memory} if more else {})

    monkeypatch.setattr(suites_module, "one", one)
    return suites_module


def arguments(suite, tmp_path, **more):
    common = {"task": "Cartpole", "device": "cpu", "num_threads": 1, "num_envs": None, "steps": 2, "seed": 1}
    names = {"sizes": None, "plot": None, "json": tmp_path / "out.json", "memory_steps": None, "cold": False}
    return SimpleNamespace(suite=suite, train_seconds=1, **(common | names | more))


def test_the_scale_suite_keeps_the_sizes_that_fit_and_draws_them(suites, tmp_path, capsys):
    pytest.importorskip("matplotlib")
    suites.run_suite(arguments("scale", tmp_path, plot=tmp_path / "plots" / "scale.png"), [])
    content = json.loads((tmp_path / "out.json").read_text())
    assert [row["num_envs"] for row in content["sizes"]] == [64, 256, 1024, 4096, 16384]
    assert [row.get("error") for row in content["sizes"]] == [None, None, *["out of memory"] * 3]
    assert content["memory"] == {"num_envs": 64, "samples": [[64, 5], [128, 5]], "bytes_per_million_steps": 0.0}
    assert content["machine"]["versions"]["torch"]
    assert (tmp_path / "plots" / "scale.png").stat().st_size > 1000
    assert "25,600" in capsys.readouterr().out


def test_what_was_measured_before_a_failure_is_kept(suites, tmp_path, monkeypatch):
    def broken(*_):
        raise RuntimeError("the machine went away")

    monkeypatch.setattr(suites, "time_to_learn", broken)
    with pytest.raises(RuntimeError, match="went away"):
        suites.run_suite(arguments("gpu", tmp_path, sizes=[8]), [])
    content = json.loads((tmp_path / "out.json").read_text())
    assert [row["num_envs"] for row in content["sizes"]] == [8]


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        ("--suite gpu --plot a.png", "--plot belongs to --suite scale"),
        ("--task Cartpole --cold", "--cold belongs to --suite gpu"),
        ("--task Cartpole --sizes 4", "--sizes belongs to --suite scale or --suite startup or --suite gpu"),
        ("--task Cartpole --train_seconds 4", "--train_seconds belongs to --suite gpu"),
        ("--suite scale --profile", "--profile belongs to no --suite"),
        ("--suite gpu --profile_training 2", "--profile_training belongs to no --suite"),
        ("--suite scale --num_envs 4", "--num_envs belongs to no --suite or --suite startup or --suite gpu"),
        ("--suite startup --memory_steps 4", "--memory_steps belongs to no --suite or --suite scale"),
        ("--suite startup --num_envs 4 --sizes 8", "--sizes and --num_envs both say"),
        ("--suite scale --sizes 4,b", "argument --sizes: expected a whole number of at least 1, got 'b'"),
        ("--task Cartpole --json .", "cannot write '.': it is a folder"),
    ],
)
def test_a_flag_that_would_do_nothing_is_refused(monkeypatch, capsys, flags, message):
    monkeypatch.setattr(sys, "argv", ["benchmark.py", *flags.split()])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(SCRIPTS / "benchmark.py"), run_name="__main__")
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_without_a_task_or_a_suite_the_benchmark_asks_for_one(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["benchmark.py"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(SCRIPTS / "benchmark.py"), run_name="__main__")
    assert ended.value.code == 2
    assert "required: --task (or --suite)" in capsys.readouterr().err


def test_a_measurement_has_its_parts_and_a_memory_that_does_not_grow(monkeypatch, tmp_path):
    threads = torch.get_num_threads()
    flags = ["--task=Cartpole", "--device=cpu", "--num_threads=1", "--num_envs=4", "--steps=3", "--memory_steps=800"]
    monkeypatch.setattr(sys, "argv", ["benchmark.py", *flags, f"--json={tmp_path / 'one.json'}"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(SCRIPTS / "benchmark.py"), run_name="__main__")
    torch.set_num_threads(threads)
    assert ended.value.code == 0
    result = json.loads((tmp_path / "one.json").read_text())
    parts = [result[f"{name}_s"] for name in ("scene", "compile_and_engine", "managers", "startup_events")]
    assert 0.0 < sum(parts) <= result["make_env_s"] <= result["ready_s"]
    assert result["captures_while_measuring"] == 0
    samples = result["memory"]["samples"]
    assert samples[-1][0] >= 800
    assert samples[-1][1] - samples[len(samples) // 5][1] < 2 * 2**20


def test_the_gpu_suite_asks_for_a_gpu(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    monkeypatch.setattr(sys, "argv", ["benchmark.py", "--suite=gpu", f"--json={tmp_path / 'gpu.json'}"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(SCRIPTS / "benchmark.py"), run_name="__main__")
    assert ended.value.code == 2
    assert "error: --suite gpu needs a GPU, and torch finds none here; --device cpu" in capsys.readouterr().err
    assert not (tmp_path / "gpu.json").exists()


@pytest.mark.slow
def test_the_gpu_suite_runs_from_end_to_end_on_warps_cpu_device(monkeypatch, tmp_path):
    flags = ["--suite=gpu", "--device=cpu", "--sizes=2,4", "--steps=2", "--num_envs=4", "--train_seconds=60"]
    overrides = ["env.sim.physics=warp", "agent.max_iterations=2", "agent.save_interval=1"]
    monkeypatch.setattr(suites_module, "EPISODES", 4)
    monkeypatch.setattr(sys, "argv", ["benchmark.py", *flags, f"--json={tmp_path / 'gpu.json'}", *overrides])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(SCRIPTS / "benchmark.py"), run_name="__main__")
    assert ended.value.code == 0
    content = json.loads((tmp_path / "gpu.json").read_text())
    assert [(row["engine"], row["captures_while_measuring"]) for row in content["sizes"]] == [("warp", 0)] * 2
    training = content["training"]
    assert training["status"] == 0
    assert training["seconds_to_learn"] is None
    assert [iteration for iteration, _, _ in training["checkpoints"]] == [1, 2]
