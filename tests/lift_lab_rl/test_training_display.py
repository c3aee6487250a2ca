"""What a training run shows: a panel that fits the terminal, and plain lines where there is none."""

import io

import pytest
from rich.console import Console

from lift_lab_rl.rsl_rl.progress import IterationReport, Progress, clock

TERMS = {
    "Episode_Reward/reaching_object": 0.81,
    "Episode_Reward/object_goal_tracking_fine_grained": 2.4,
    "Episode_Reward/joint_vel": -0.0031,
    "Metrics/object_pose/position_error": 0.12,
    "Metrics/object_pose/jerk": 123456.7,
    "Curriculum/joint_vel": -0.1,
    "Episode_Termination/time_out": 499.0,
    "of_a_task": 1.0,
}


def report(iteration=1):
    return IterationReport(
        iteration, 1200, 12288 * iteration, 12288, 1.5, 0.5, 123.4, 249.0, 0.931, 1e-4, 0.34, terms=dict(TERMS)
    )


def show(terminal, width=80):
    text = io.StringIO()
    console = Console(file=text, force_terminal=terminal, width=width, height=50, color_system=None)
    with Progress("a run", console) as progress:
        progress.show(report(1))
        progress.show(report(2))
        progress.note("a note")
    return text.getvalue()


@pytest.mark.parametrize("width", [80, 100, 120])
def test_the_panel_fits_the_terminal_and_cuts_nothing(width):
    lines = show(True, width).splitlines()
    panel = lines[max(i for i, line in enumerate(lines) if "a run" in line) :]
    assert all(len(line) <= width for line in panel if line.startswith(("╭", "│", "╰")))
    text = "\n".join(panel)
    for name in TERMS:
        assert (name.partition("/")[2] or name) in text
    assert "…" not in text
    for value in ("2/1200", "24,576", "6,144", "123.40", "93.1%", "2.400", "-0.0031", "-0.100", "1.235e+05"):
        assert value in text


def test_a_wide_terminal_has_the_terms_side_by_side():
    assert len(show(True, 120).splitlines()) < len(show(True, 80).splitlines())


def test_without_a_terminal_each_iteration_is_one_plain_line():
    lines = show(False).splitlines()
    assert len(lines) == 3
    assert (
        lines[0]
        .strip()
        .startswith(
            "1/1200 | success rate 93.1% | mean reward 123.40 | mean episode length 249 | 12k steps | "
            "6,144/s (collect 1.50 s, learn 0.50 s) | left 39:58 | Episode_Reward/reaching_object 0.810"
        )
    )
    assert "Curriculum/joint_vel -0.100" in lines[0]
    assert lines[2] == "a note"
    assert "\x1b" not in "".join(lines)


@pytest.mark.parametrize(("seconds", "text"), [(0, "0:00"), (125, "2:05"), (3725, "1:02:05"), (float("inf"), "?")])
def test_times_are_written_as_a_clock_shows_them(seconds, text):
    assert clock(seconds) == text
