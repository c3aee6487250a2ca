"""A check of an installation in half a minute: import, load USD, lift with a shipped policy, train, continue, measure.

``python -m pytest tests/test_smoke.py``. MuJoCo-Warp, whose kernels take minutes to compile once, is left to the full
suite.
"""

import importlib
import pkgutil
import sys
from pathlib import Path

import pytest
import torch

from lift_lab.app import cli

PACKAGES = ("lift_lab", "lift_lab_assets", "lift_lab_rl", "lift_lab_tasks", "lift_lab_cli")
OPTIONAL = {"av", "h5py", "matplotlib", "skrl", "stable_baselines3", "viser", "wandb"}
"""Packages of the extras: a module that needs one may be missing."""


@pytest.fixture
def program(monkeypatch, tmp_path, capsys):
    """Runs a program of lift_lab_cli in an empty folder; returns what it prints."""
    threads = torch.get_num_threads()
    monkeypatch.chdir(tmp_path)

    def run(name, *words):
        monkeypatch.setattr(sys, "argv", [name, *map(str, words)])
        with pytest.raises(SystemExit) as ended:
            cli.run(importlib.import_module(f"lift_lab_cli.{name}").main)
        captured = capsys.readouterr()
        assert ended.value.code == 0, captured.err
        return captured.out

    yield run
    torch.set_num_threads(threads)


def test_every_module_imports():
    modules = [
        info.name
        for package in PACKAGES
        for info in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}.")
        if not info.name.endswith("__main__")
    ]
    for name in modules:
        try:
            importlib.import_module(name)
        except ModuleNotFoundError as error:
            if error.name not in OPTIONAL:
                raise
    assert len(modules) > 300


def test_shipped_policy_lifts_the_cube(program):
    import json

    task = ["--task", "Lift-Cube-Franka-CL", "--checkpoint", "pretrained", "--num_threads", 2]
    program("evaluate", *task, "--num_envs", 16, "--episodes", 16, "--seed", 1, "--json", "success.json")
    result = json.loads(Path("success.json").read_text())
    assert result["success_rate"]["16"] > 0.9  # about 1 in docs/pretrained.md


def test_training_runs_and_continues(program):
    words = ["--task", "Lift-Cube-Franka-CL", "--num_envs", 32, "--num_threads", 2, "--seed", 1]
    program("train", *words, "--max_iterations", 2)
    program("train", *words, "--max_iterations", 3, "--resume")
    folders = sorted(Path("logs/rsl_rl").glob("*/*"))
    models = [sorted(path.name for path in folder.glob("model_*.pt")) for folder in folders]
    assert "model_2.pt" in models[0]
    assert "model_3.pt" in [name for names in models for name in names]
    program("play", *words[:2], "--num_envs", 2, "--steps", 5)
    assert list(Path("logs").rglob("policy.onnx"))
