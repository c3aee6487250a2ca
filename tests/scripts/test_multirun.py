"""--multirun runs a script once for each combination of the values that overrides list."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from lift_lab.app.multirun import expand
from lift_lab.utils.errors import ConfigError

SCRIPTS = Path(__file__).parents[2] / "scripts"
ECHO = """
import sys
from lift_lab.app import cli

def main():
    parser = cli.Parser("Echo.")
    parser.add_argument("--task", default="")
    args, overrides = parser.parse()
    print(args.task, *overrides, sep=" ")
    return 3 if "env.seed=2" in overrides else 0

cli.run(main)
"""


def run(*args, cwd):
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, *map(str, args)], cwd=cwd, env=environment, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def test_every_combination_is_listed_with_the_last_override_changing_fastest():
    jobs = expand(["a=1,2", "b=[1,2]", "env/curriculum=step,none", "c=choice(x,y)"])
    assert [" ".join(job) for job in jobs] == [
        "a=1 b=[1,2] env/curriculum=step c=x",
        "a=1 b=[1,2] env/curriculum=step c=y",
        "a=1 b=[1,2] env/curriculum=none c=x",
        "a=1 b=[1,2] env/curriculum=none c=y",
        "a=2 b=[1,2] env/curriculum=step c=x",
        "a=2 b=[1,2] env/curriculum=step c=y",
        "a=2 b=[1,2] env/curriculum=none c=x",
        "a=2 b=[1,2] env/curriculum=none c=y",
    ]
    assert expand(["env.seed=range(1,4)"]) == [["env.seed=1"], ["env.seed=2"], ["env.seed=3"]]
    assert expand([]) == [[]]


def test_what_cannot_be_run_through_is_answered():
    with pytest.raises(ConfigError, match="an interval has no values"):
        expand(["a=interval(0,1)"])
    with pytest.raises(ConfigError, match=r"cannot read the override 'a=\[1'"):
        expand(["a=[1"])


def test_a_script_is_run_once_for_each_combination_and_says_which_failed(tmp_path):
    (tmp_path / "echo.py").write_text(ECHO)
    status, out, err = run("echo.py", "-m", "--task", "X", "env.seed=1,2,3", cwd=tmp_path)
    assert status == 3
    assert out.splitlines() == [
        "[1/3] env.seed=1",
        "X env.seed=1",
        "[2/3] env.seed=2",
        "X env.seed=2",
        "[3/3] env.seed=3",
        "X env.seed=3",
    ]
    assert err == "1 of 3 runs failed: 2\n"
    assert [path.name for path in tmp_path.iterdir()] == ["echo.py"]


def test_a_module_is_run_again_as_a_module(tmp_path):
    (tmp_path / "tools").mkdir()
    (tmp_path / "tools" / "__init__.py").touch()
    (tmp_path / "tools" / "echo.py").write_text("from . import __name__ as package\n" + ECHO)
    status, out, _ = run("-m", "tools.echo", "-m", "--task", "X", "env.seed=1,3", cwd=tmp_path)
    assert status == 0
    assert out.splitlines() == ["[1/2] env.seed=1", "X env.seed=1", "[2/2] env.seed=3", "X env.seed=3"]


def test_training_runs_go_to_folders_of_their_own(tmp_path):
    flags = ["--task", "Cartpole", "--device", "cpu", "--num_envs", 4, "--num_threads", 1, "--max_iterations", 1]
    status, out, _ = run(
        SCRIPTS / "rsl_rl" / "train.py", *flags, "--multirun", "agent.algorithm.gamma=0.9,0.95", cwd=tmp_path
    )
    assert status == 0
    assert "[2/2] agent.algorithm.gamma=0.95" in out
    runs = sorted((tmp_path / "logs" / "rsl_rl" / "cartpole").iterdir())
    assert [
        next(line.lstrip() for line in (run / "params" / "agent.yaml").open() if "gamma:" in line) for run in runs
    ] == ["gamma: 0.9\n", "gamma: 0.95\n"]
    assert {path.name for path in tmp_path.iterdir()} == {"logs"}
