"""A learning gate: a few minutes of the README's main command teach the gripper to reach for the cube."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ITERATIONS = 60


@pytest.mark.slow
def test_training_learns_to_reach(tmp_path):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    command = [
        sys.executable,
        str(ROOT / "scripts" / "rsl_rl" / "train.py"),
        "--task=Lift-Cube-Franka-CL",
        f"--max_iterations={ITERATIONS}",
        "--seed=1",
    ]
    env = {**os.environ, "PYTHONUNBUFFERED": "1"}
    subprocess.run(command, cwd=tmp_path, env=env, check=True, capture_output=True, timeout=900)
    runs = list((tmp_path / "logs" / "rsl_rl").glob("*/*"))
    assert len(runs) == 1
    assert (runs[0] / f"model_{ITERATIONS}.pt").is_file()
    events = EventAccumulator(str(runs[0]), size_guidance={"scalars": 0})
    events.Reload()
    reaching = [event.value for event in events.Scalars("Episode_Reward/reaching_object")]
    # an untrained policy waves its arm about 0.4 m from the cube: 1 - tanh(4) = 0.0007
    assert sum(reaching[:5]) / 5 < 0.02
    # at the start of episodes the tool is 0.4 m away; 0.2 means it spends its time within about 0.1 m
    assert sum(reaching[-5:]) / 5 > 0.2
