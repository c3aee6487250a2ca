"""The tutorials run as they are written."""

import os
import re
import runpy
import shlex
import subprocess
import sys
from pathlib import Path

import gymnasium as gym
import pytest
import torch
from page_files import forget_own_task, write_files
from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

from lift_lab_tasks.utils import parse_env_cfg
from lift_lab_tasks.utils.hydra import compose

ROOT = Path(__file__).resolve().parents[2]
TUTORIALS = ROOT / "docs" / "tutorials"


def _blocks(name: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", (TUTORIALS / name).read_text(), flags=re.DOTALL | re.MULTILINE)


def _run(*command, cwd: Path, path: bool = True) -> str:
    """Run Python in a folder, which ``path`` puts on the module path; what it printed."""
    env = {**os.environ, "OMP_NUM_THREADS": "1"}
    if path:
        env["PYTHONPATH"] = os.pathsep.join([str(cwd), *filter(None, [env.get("PYTHONPATH")])])
    done = subprocess.run([sys.executable, *map(str, command)], cwd=cwd, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


OWN_TASK = "own_task.md"


@pytest.mark.parametrize("name", sorted(path.name for path in TUTORIALS.glob("*.md") if path.name != OWN_TASK))
def test_python_blocks_of_a_tutorial_run_as_one_file(name, tmp_path):
    (tmp_path / "balance.py").write_text("\n\n".join(_blocks(name, "python")))
    printed = _run("balance.py", cwd=tmp_path)
    expected = {
        "first_task.md": "mean reward of a step: 0.0",  # 1 / 60 s times at most 1
        "swap_a_reward.md": "reaching_object",
        "add_a_curriculum.md": "Curriculum/start_area/half_width",
    }
    assert expected[name] in printed


def test_the_task_of_the_first_tutorial_trains_by_its_name(tmp_path):
    (tmp_path / "balance.py").write_text("\n\n".join(_blocks("first_task.md", "python")))
    (line,) = (text for text in _blocks("first_task.md", "bash") if "train" in text)
    program, *args = shlex.split(line)
    assert program == "lift-lab"
    args[args.index("--max_iterations") + 1] = "2"
    smaller = ["env.scene.num_envs=16", "env.sim.device=cpu"]
    _run("-P", "-m", "lift_lab_cli", *args, *smaller, cwd=tmp_path, path=False)
    assert len(list((tmp_path / "logs" / "rsl_rl" / "cartpole").glob("*/model_2.pt"))) == 1


@pytest.mark.parametrize("name", ["swap_a_reward.md", "add_a_curriculum.md"])
def test_overrides_of_a_tutorial_are_understood_and_change_the_task(name):
    lines = [line for block in _blocks(name, "bash") for line in block.replace("\\\n", " ").splitlines()]
    assert lines
    for line in lines:
        words = shlex.split(line)
        assert words[:2] == ["lift-lab", "train"]
        task = words[words.index("--task") + 1]
        plain, _ = compose(task, "rsl_rl_cfg_entry_point", [])
        changed, _ = compose(task, "rsl_rl_cfg_entry_point", words[words.index(task) + 1 :])
        assert changed.to_dict() != plain.to_dict(), line


@pytest.fixture
def own_task(tmp_path, monkeypatch):
    """An empty folder, then with the files of the page, as the current folder."""
    write_files(TUTORIALS / OWN_TASK, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    yield tmp_path
    forget_own_task()


def test_a_package_in_an_empty_folder_trains(own_task, monkeypatch, capsys):
    """The current folder is not on the module path, as for an installed command (-P)."""
    flags = ["--num_envs", "32", "--max_iterations", "3", "--device", "cpu", "--num_threads", "1"]
    printed = _run("-P", "-m", "lift_lab_cli", "train", "--task", "knock:Knock-Pin", *flags, cwd=own_task, path=False)
    assert "finished after 3 iterations" in printed
    (run,) = (own_task / "logs" / "rsl_rl" / "knock_pin").iterdir()
    assert (run / "model_3.pt").is_file()
    events = EventAccumulator(str(run), size_guidance={"scalars": 0})
    events.Reload()
    assert {"Metrics/success_rate", "Episode_Reward/fallen"} <= set(events.Tags()["scalars"])

    monkeypatch.setattr(torch, "randn", lambda *shape, **_: torch.zeros(*shape))
    runpy.run_path("watch.py")
    assert capsys.readouterr().out.startswith("observations: torch.Size([4, 28]) mean reward of a step: -0.0")


def test_the_pin_of_the_own_task_falls_when_it_leans(own_task):
    """Success is a matter of the pin alone: 0 for a pin that stands, 1 for one that lies."""
    cfg = parse_env_cfg("knock:Knock-Pin", device="cpu", num_envs=3)
    cfg.sim.num_threads = 1
    env = gym.make("knock:Knock-Pin", cfg=cfg).unwrapped
    env.reset()
    pin, steps = env.scene["pin"], torch.zeros(3, 7)
    leans = torch.tensor([0.0, 1.0, 1.5])  # rad; success begins at 60 degrees, 1.05 rad
    pose = pin.data.root_state_w[:, :7].clone()
    pose[:, 3:] = torch.stack([torch.cos(leans / 2), torch.sin(leans / 2), 0 * leans, 0 * leans], dim=1)
    pose[:, 2] += 0.5  # in the air, where nothing turns it
    pin.write_root_pose_to_sim(pose)
    pin.write_root_velocity_to_sim(torch.zeros(3, 6))
    env.step(steps)
    value = env.metrics_manager.episode_value("success")
    env.close()
    assert value.tolist() == [0.0, 0.0, 1.0]
