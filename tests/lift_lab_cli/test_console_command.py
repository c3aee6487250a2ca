"""The console command runs the programs, and names itself as the user called it."""

import os
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import lift_lab
from lift_lab.app import cli, program
from lift_lab_cli import main as command

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def call(monkeypatch, capsys):
    """Runs ``lift-lab`` in this process; returns exit status, output and errors."""

    def run(*args):
        monkeypatch.setattr(sys, "argv", ["/somewhere/bin/lift-lab", *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            command.console()
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    return run


@pytest.mark.parametrize("args", [[], ["--help"], ["-h"]])
def test_help_has_one_line_for_each_command(call, args):
    status, out, err = call(*args)
    assert (status, err) == (0, "")
    listed = re.findall(r"^  (\w+)  +(\S.*)$", out, flags=re.MULTILINE)
    assert [name for name, _ in listed] == list(command.COMMANDS)
    assert out.startswith("usage: lift-lab COMMAND")


@pytest.mark.parametrize("name", list(command.COMMANDS))
def test_every_command_answers_help_under_its_own_name(call, name):
    status, out, _ = call(name, "--help")
    assert status == 0
    assert out.startswith(f"usage: lift-lab {name} [-h]")


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["trian"], "error: unknown command 'trian'; did you mean train?"),
        (["desribe", "Cartpole"], "error: unknown command 'desribe'; did you mean describe?"),
        (["zzz"], "error: unknown command 'zzz'; lift-lab --help lists all"),
        (["--versoin"], "error: unknown flag '--versoin'; lift-lab --help lists all"),
        (["train"], "error: the following arguments are required: --task"),
        (["train", "--library"], "error: argument --library: expected one argument"),
        (["describe"], "error: the following arguments are required: ID"),
        (["describe", "Cartpol"], "error: unknown task 'Cartpol'; did you mean 'Cartpole'"),
        (["list", "--describe", "Cartpole", "--keyword", "a"], "error: --keyword filters the list"),
    ],
)
def test_a_mistake_is_one_line(call, args, message):
    status, out, err = call(*args)
    assert (status, out) == (2, "")
    assert err.startswith(message)
    assert err.count("\n") == 1


def test_the_version_is_that_of_the_project(call):
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert lift_lab.__version__ == wanted
    assert call("--version") == (0, f"lift-lab {wanted}\n", "")


def test_describe_is_what_list_describes(call):
    shown = call("describe", "Cartpole", "env.decimation=3")
    assert shown == call("list", "--describe", "Cartpole", "env.decimation=3")
    assert shown[0] == 0
    assert "cartpole_env_cfg:CartpoleEnvCfg" in shown[1]


def test_library_chooses_the_learner(call):
    status, out, _ = call("train", "--library", "skrl", "--help")
    assert status == 0
    assert "logs/skrl" in out
    assert "--trust" in out  # which rsl_rl's checkpoints do not have


def test_the_project_installs_the_command():
    entry = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["scripts"]["lift-lab"]
    module, _, name = entry.partition(":")
    assert getattr(import_module(module), name) is command.console


def test_a_command_leaves_no_trace_in_the_process(call):
    before = list(sys.argv)
    call("train")
    assert sys.argv[1:] == ["train"]
    assert not program.current().name.startswith("lift-lab train")
    assert before != sys.argv


def test_the_module_repeats_itself_and_keeps_the_exit_status(tmp_path):
    """A sweep starts the command again for each run; the status of a run that failed is the sweep's."""
    words = ["-m", "lift_lab_cli", "benchmark", "--task=X", "--cold", "-m", "env.seed=1,2"]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, *words], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == cli.USAGE_ERROR
    assert done.stdout.splitlines() == ["[1/2] env.seed=1", "[2/2] env.seed=2"]
    wrong = "error: --cold belongs to --suite gpu"
    assert done.stderr.splitlines() == [wrong, wrong, "2 of 2 runs failed: 1, 2"]
    assert not list(tmp_path.iterdir())


def test_help_of_a_command_imports_neither_torch_nor_a_library():
    code = (
        "import sys; from lift_lab_cli import main; sys.argv = ['lift-lab', 'train', '--help']\n"
        "try: main.console()\n"
        "except SystemExit: print([m for m in ('torch', 'gymnasium', 'rsl_rl', 'mujoco') if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.splitlines()[-1] == "[]"


def test_every_script_is_a_few_lines():
    """The programs are in the packages, so that the wheel has them; ``scripts/maintainers`` is for this repository."""
    long = {
        str(path.relative_to(ROOT)): len(path.read_text().splitlines())
        for path in (ROOT / "scripts").rglob("*.py")
        if "maintainers" not in path.parts and len(path.read_text().splitlines()) > 10
    }
    assert not long
