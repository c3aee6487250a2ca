"""The tutorials run as they are written."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from lift_lab_tasks.utils.hydra import compose

ROOT = Path(__file__).resolve().parents[2]
TUTORIALS = ROOT / "docs" / "tutorials"


def _blocks(name: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", (TUTORIALS / name).read_text(), flags=re.DOTALL | re.MULTILINE)


def _run(*command, cwd: Path) -> str:
    env = {**os.environ, "PYTHONPATH": str(cwd), "OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, *map(str, command)], cwd=cwd, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout


@pytest.mark.parametrize("name", sorted(path.name for path in TUTORIALS.glob("*.md")))
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
    (line,) = (text for text in _blocks("first_task.md", "bash") if "train.py" in text)
    script, *args = shlex.split(line)[2:]
    args[args.index("--max_iterations") + 1] = "2"
    _run(ROOT / script, *args, "env.scene.num_envs=16", "env.sim.device=cpu", cwd=tmp_path)
    assert len(list((tmp_path / "logs" / "rsl_rl" / "cartpole").glob("*/model_2.pt"))) == 1


@pytest.mark.parametrize("name", ["swap_a_reward.md", "add_a_curriculum.md"])
def test_overrides_of_a_tutorial_are_understood_and_change_the_task(name):
    lines = [line for block in _blocks(name, "bash") for line in block.splitlines()]
    assert lines
    for line in lines:
        words = shlex.split(line)
        assert (ROOT / words[1]).is_file()
        task = words[words.index("--task") + 1]
        plain, _ = compose(task, "rsl_rl_cfg_entry_point", [])
        changed, _ = compose(task, "rsl_rl_cfg_entry_point", words[words.index(task) + 1 :])
        assert changed.to_dict() != plain.to_dict(), line
