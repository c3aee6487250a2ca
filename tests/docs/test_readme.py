"""The README keeps its promises: one command for users, one for tests, one screen, three lines of Python."""

import re
import subprocess
from pathlib import Path

import gymnasium as gym

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()


def test_one_command_installs_and_trains_and_one_installs_and_tests():
    commands = [line.strip() for line in README.splitlines() if line.startswith("    pip install")]
    assert len(commands) == 2
    assert commands[0].endswith(" && lift-lab train --task Lift-Cube-Franka-CL")
    assert commands[1].endswith(" && python -m pytest")


def test_ci_finds_the_command_of_the_tests():
    """The line of .ci/run that reads the README prints the second command."""
    (line,) = re.findall(r"^tests=\$\((.*)\)$", (ROOT / ".ci" / "run").read_text(), flags=re.MULTILINE)
    found = subprocess.run(["bash", "-c", line], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert found == '    pip install -e ".[test]" && python -m pytest\n'


def test_it_is_one_screen():
    assert len(README.splitlines()) < 65


def test_its_python_runs():
    (block,) = re.findall(r"^```python\n(.*?)^```$", README, flags=re.DOTALL | re.MULTILINE)
    names = {}
    exec(block.replace("64", "4"), names)
    try:
        assert isinstance(names["env"], gym.Env)
        assert names["rewards"].shape == (4,)
        assert names["observations"]["policy"].shape[0] == 4
    finally:
        names["env"].close()
