"""A run that is filmed ends with the model of one that is not, and either can be continued from the other."""

import filecmp
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("av")

TRAIN = Path(__file__).resolve().parents[2] / "scripts" / "rsl_rl" / "train.py"
FLAGS = ["--task", "Lift-Cube-Franka", "--device", "cpu", "--num_envs", "8", "--seed", "3", "agent.save_interval=1"]
FILMED = [
    "--video",
    "--video_length",
    "6",
    "--video_interval",
    "20",
    "--video_envs",
    "2",
    "--video_rewards",
    "env.viewer.resolution=[64,48]",
]


def train(folder, *flags):
    folder.mkdir(exist_ok=True)
    command = [sys.executable, str(TRAIN), *FLAGS, *flags]
    out = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
    assert out.returncode == 0, out.stderr
    return out.stdout


@pytest.mark.slow
def test_a_filmed_run_ends_with_the_same_bytes_as_one_that_is_not(tmp_path):
    train(tmp_path / "plain", "--max_iterations", "3")
    train(tmp_path / "filmed", "--max_iterations", "2", *FILMED)
    text = train(tmp_path / "filmed", "--max_iterations", "3", "--resume")
    assert "resuming" in text
    (plain,) = (tmp_path / "plain").rglob("model_3.pt")
    (filmed,) = (tmp_path / "filmed").rglob("model_3.pt")
    assert filecmp.cmp(plain, filmed, shallow=False)
    videos = sorted(path.name for path in (tmp_path / "filmed").rglob("*.mp4"))
    assert videos == ["step_0.mp4", "step_20.mp4", "step_40.mp4"] or "could not be drawn" in text
    assert not list((tmp_path / "filmed").rglob("*.film"))
