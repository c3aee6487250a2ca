"""The command lines that show and test the importer."""

from __future__ import annotations

import importlib
import runpy
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from PIL import Image

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


def test_usd_info_draws_the_whole_model_in_the_middle_of_a_picture(run, ball, tmp_path):
    status, _, err = run("usd_info.py", ball, "--view", tmp_path / "out" / "ball.png")
    if "no OpenGL library was found" in err:
        pytest.skip(err)
    assert status == 0
    picture = np.asarray(Image.open(tmp_path / "out" / "ball.png")).astype(int)
    assert picture.shape == (720, 960, 3)
    assert picture.mean() > 100
    assert picture.min() > 30  # smooth edges blend into the background, not into black
    rows, columns = np.nonzero(np.abs(picture - picture[360, 10]).max(axis=2) > 60)  # the background is lighter
    assert 0.5 * 720 < np.ptp(rows) < 0.9 * 720
    assert (rows.mean(), columns.mean()) == pytest.approx((360, 480), abs=60)


def test_usd_info_without_an_opengl_library_writes_nothing_and_names_the_packages(run, ball, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco.egl", None)
    for name in ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    if not sys.platform.startswith("linux"):
        pytest.skip("EGL is Linux's")
    status, _, err = run("usd_info.py", ball, "--view", tmp_path / "a.png", "--mjcf", tmp_path / "a.xml")
    assert status == 2
    assert err.startswith("error: --view: no OpenGL library was found; on Debian or Ubuntu: apt-get install libegl1")
    assert err.count("\n") == 1
    assert {path.name for path in tmp_path.iterdir()} == {"ball.usda"}


def test_damaged_files_of_every_format_import_or_are_refused_and_nothing_else(tmp_path, monkeypatch):
    """A short run of the fuzzer; its processes survive what a file does to them."""
    monkeypatch.syspath_prepend(str(SCRIPTS / "maintainers"))  # the child processes look the script up by name
    fuzz = importlib.import_module("usd_fuzz")
    seeds = fuzz.seed_files(shipped=False)
    assert {seed.suffix for seed in seeds} == {"usda", "usdc", "usdz"}
    counts = fuzz.fuzz(seeds, cases=150, seconds=15, seed=1, keep=tmp_path)
    assert fuzz.failures(counts) == 0, list(tmp_path.iterdir())
    assert sum(counts.values()) > 0
