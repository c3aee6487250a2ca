"""The command lines that show and test the importer."""

from __future__ import annotations

import importlib
import runpy
import sys
from pathlib import Path

import mujoco
import pytest

SCRIPTS = Path(__file__).parents[3] / "scripts"


@pytest.fixture
def run(monkeypatch, capsys):
    """Runs a tool in this process; returns exit status, output and errors."""

    def call(name, *args):
        monkeypatch.setattr(sys, "argv", [name, *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(SCRIPTS / name), run_name="__main__")
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    return call


@pytest.fixture
def ball(author, tmp_path):
    a = author()
    a.body("/Robot/ball", pos=(0, 0, 1), mass=2.0)
    a.gprim("/Robot/ball/c", "Sphere", radius=0.1)
    a.attrs("/Robot/ball", {"physxRigidBody:linearDamping": 0.5})
    path = tmp_path / "ball.usda"
    a.stage.GetRootLayer().Export(str(path))
    return path


def test_usd_info_prints_the_report_and_writes_an_mjcf_that_compiles(run, ball, tmp_path):
    status, out, _ = run("usd_info.py", ball, "--mjcf", tmp_path / "out" / "ball.xml")
    assert status == 0
    assert "linearDamping" in out
    assert "1 bodies, 6 degrees of freedom" in out
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "out" / "ball.xml"))
    assert model.body("ball").mass[0] == pytest.approx(2.0)
    assert "integrator implicitfast" in out
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert (model.opt.iterations, model.opt.ls_iterations) == (10, 20)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["none.usda"], "no such file"),
        (["FILE", "--strict"], "linearDamping"),
        (["FILE", "--variant", "x"], "SET=NAME"),
    ],
)
def test_usd_info_answers_a_mistake_in_one_line_with_status_two(run, ball, args, message):
    status, _, err = run("usd_info.py", *[ball if arg == "FILE" else arg for arg in args])
    assert status == 2
    assert message in err
    assert err.count("\n") == 1


def test_damaged_files_of_every_format_import_or_are_refused_and_nothing_else(tmp_path, monkeypatch):
    """A short run of the fuzzer; its processes survive what a file does to them."""
    monkeypatch.syspath_prepend(str(SCRIPTS / "maintainers"))  # the child processes look the script up by name
    fuzz = importlib.import_module("usd_fuzz")
    seeds = fuzz.seed_files(shipped=False)
    assert {seed.suffix for seed in seeds} == {"usda", "usdc", "usdz"}
    counts = fuzz.fuzz(seeds, cases=150, seconds=15, seed=1, keep=tmp_path)
    assert fuzz.failures(counts) == 0, list(tmp_path.iterdir())
    assert sum(counts.values()) > 0
