"""Wrong command lines are refused in one line with exit status 2, and nothing is written."""

import sys
from pathlib import Path

import pytest
import torch

TOOLS = Path(__file__).parents[2] / "scripts" / "maintainers"
sys.path.insert(0, str(TOOLS))
from wrong_inputs import WRONG_INPUTS, Answer, WrongInput, problem, run, shuffled  # noqa: E402

SAMPLE = 45


@pytest.fixture(autouse=True)
def _threads():
    threads = torch.get_num_threads()
    yield
    torch.set_num_threads(threads)


def test_there_are_many_and_no_two_are_the_same():
    assert len(WRONG_INPUTS) == len({str(wrong) for wrong in WRONG_INPUTS}) >= 250
    assert {wrong.script for wrong in WRONG_INPUTS} >= {
        *("rsl_rl/train.py", "rsl_rl/play.py", "rsl_rl/evaluate.py", "rsl_rl/study.py", "benchmark.py"),
        *("list_envs.py", "sb3/train.py", "sb3/play.py", "skrl/train.py", "skrl/play.py"),
    }


def test_a_seed_fixes_the_order():
    assert shuffled(20, seed=1) == shuffled(20, seed=1) != shuffled(20, seed=2)


@pytest.mark.parametrize("wrong", shuffled(SAMPLE), ids=str)
def test_a_wrong_input_is_refused_in_one_line(wrong, tmp_path):
    for library in ("skrl", "sb3"):
        if wrong.script.startswith(library):
            pytest.importorskip({"skrl": "skrl", "sb3": "stable_baselines3"}[library])
    assert problem(wrong, run(wrong, tmp_path)) is None


@pytest.mark.parametrize(
    ("answer", "lacks"),
    [
        (Answer(0, "", ()), "exit status 0"),
        (Answer(None, "ValueError: no", ()), "exit status None"),
        (Answer(2, "error: dt\nmore", ()), "2 lines"),
        (Answer(2, "error: something", ()), "['dt'] not in"),
        (Answer(2, "error: dt", ("logs",)), "written: logs"),
    ],
)
def test_what_an_answer_lacks_is_told(answer, lacks):
    assert problem(WrongInput("x.py", (), ("dt",)), answer).startswith(lacks)
    assert problem(WrongInput("x.py", (), ("dt",)), Answer(2, "error: dt is bad\n", ())) is None
