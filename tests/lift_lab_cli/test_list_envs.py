"""The list of tasks in terminals of several widths and in a pipe."""

import io

import pytest
from rich.console import Console

from lift_lab_cli.list_envs import NO_LIMIT, show

LONG = "My-Company-Very-Long-Task-Name-For-A-Robot-Play"
ROWS = [
    ("Cartpole", "lift_lab_tasks.classic.cartpole.cartpole_env_cfg:CartpoleEnvCfg", "rsl_rl, skrl, sb3", "yes"),
    (LONG, "my_company.tasks.a_rather_long_module_path.robot_env_cfg:MyRobotEnvCfg_PLAY", "rsl_rl", ""),
]


def lines(width):
    stream = io.StringIO()
    show(Console(file=stream, width=width, color_system=None), ROWS)
    return stream.getvalue().splitlines()


@pytest.mark.parametrize("width", [20, 40, 60, 80, 100, 120, NO_LIMIT])
def test_no_id_is_cut(width):
    words = " ".join(lines(width)).split()
    assert {"Cartpole", LONG} <= set(words)
    assert "…" not in "".join(words)


@pytest.mark.parametrize(
    ("width", "left_out"),
    [(40, "environment, agents, pretrained"), (64, "environment, agents"), (90, "environment"), (NO_LIMIT, None)],
)
def test_columns_that_do_not_fit_are_named(width, left_out):
    shown = " ".join(line.strip() for line in lines(width))
    assert (f"not shown, because the terminal is narrow: {left_out} (pipe" in shown) == (left_out is not None)
    assert ("rsl_rl, skrl, sb3" in shown) == (width >= 90)
    assert ("MyRobotEnvCfg_PLAY" in shown) == (width == NO_LIMIT)


def test_a_table_fits_into_its_terminal():
    assert all(len(line) <= 90 for line in lines(90))
