"""What the page on extensions shows runs as it is written, and its table names hooks that exist."""

import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from lift_lab.envs import mdp

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "extend.md").read_text()
MODULES = (
    "lift_lab.actuators",
    "lift_lab.assets",
    "lift_lab.envs",
    "lift_lab.managers",
    "lift_lab.sensors",
    "lift_lab.sim",
    "lift_lab.sim.physics",
    "lift_lab.utils.debug_vis",
    "lift_lab.utils.modifiers",
    "lift_lab.utils.noise",
    "lift_lab.utils.saved_state",
)
ROWS = [
    [cell.strip() for cell in line.strip("|").split(" | ")]
    for line in PAGE.partition("## All hooks")[2].splitlines()
    if line.startswith("| `")
]


def find(name):
    """The class or function of a name of the table."""
    if "." in name:
        module, _, name = name.rpartition(".")
        return getattr(mdp if module == "mdp" else importlib.import_module(module), name, None)
    found = (getattr(importlib.import_module(module), name, None) for module in MODULES)
    return next((value for value in found if value is not None), None)


def test_the_blocks_of_python_run_as_one_file(tmp_path):
    blocks = re.findall(r"^```python\n(.*?)^```$", PAGE, flags=re.DOTALL | re.MULTILINE)
    (tmp_path / "mine.py").write_text("\n\n".join(blocks))
    env = {**os.environ, "OMP_NUM_THREADS": "1"}
    done = subprocess.run([sys.executable, "mine.py"], cwd=tmp_path, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    assert "'near_the_middle', 'action_change'] [1.0, 1.0, 0.5]" in done.stdout  # the pole's mass is 0.5 kg
    assert "effort after a step: [75.0, 75.0, 75.0, 75.0]" in done.stdout  # 100 N, half the way in each of two steps


@pytest.mark.parametrize("row", ROWS, ids=[f"{row[1]}.{row[0]}".replace("`", "") for row in ROWS])
def test_a_hook_of_the_table_exists_and_has_a_documented_default(row):
    assert len(row) == 5
    hooks, owner = re.findall(r"`(\w+)`", row[0]), find(row[1].strip("`")) if re.fullmatch(r"`\w+`", row[1]) else None
    if re.fullmatch(r"`\w+`", row[1]):
        assert owner is not None, row[1]
        for hook in hooks:
            assert hasattr(owner, hook) or hook in owner.__dataclass_fields__, f"{row[1]} has no {hook}"
    for example in re.findall(r"`([\w.]+)`", row[4]):
        if example[0].isupper() or "." in example:
            assert find(example) is not None, example


def test_every_hook_that_a_base_class_leaves_to_its_sub_classes_is_in_the_table():
    """What is abstract has to be written; of actuators, actions, commands, engines apart, whose page is another."""
    named = {(row[1].strip("`"), hook) for row in ROWS for hook in re.findall(r"`(\w+)`", row[0])}
    for name in ("ActuatorBase", "ActionTerm", "CommandTerm"):
        methods = {hook for hook in find(name).__abstractmethods__ if callable(vars(find(name)).get(hook))}
        assert {(name, hook) for hook in methods} <= named
