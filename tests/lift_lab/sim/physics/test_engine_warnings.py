"""What MuJoCo only prints becomes a few lines of the log, from whatever thread it comes."""

from __future__ import annotations

import ctypes
import logging
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import mujoco
import pytest

from lift_lab.sim.physics.engine_warnings import WarningThrottle, throttle_engine_warnings
from lift_lab.sim.physics.native import NativePhysics


@pytest.fixture
def throttle() -> Iterator[None]:
    """Start to count anew, and put back what was there before."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(WarningThrottle())
    yield
    mujoco.set_mju_user_warning(before)


def _mujoco_warning(text: str, times: int) -> None:
    """Let MuJoCo's C code warn; ctypes gives up Python's lock, as the threads of a batch do not hold it."""
    folder = Path(mujoco.__file__).parent
    library = ctypes.CDLL(str(next(folder.glob("*mujoco*.so*"), None) or next(folder.glob("*mujoco*.d*"))))
    for _ in range(times):
        library.mju_warning(text.encode())


@pytest.mark.usefixtures("throttle")
def test_a_thousand_warnings_of_a_kind_are_four_lines(caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture):
    with caplog.at_level(logging.WARNING):
        threads = [threading.Thread(target=_mujoco_warning, args=("Linesearch objective", 250)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        _mujoco_warning("Another one at time 0.25", 1)
        _mujoco_warning("Another one at time 0.30", 1)
    assert [record.message for record in caplog.records] == [
        "MuJoCo: Linesearch objective",
        "MuJoCo: Linesearch objective (10 times so far)",
        "MuJoCo: Linesearch objective (100 times so far)",
        "MuJoCo: Linesearch objective (1,000 times so far)",
        "MuJoCo: Another one at time 0.25",
    ]
    assert capfd.readouterr() == ("", "")


@pytest.mark.usefixtures("throttle")
def test_threads_of_the_engine_can_warn(caplog: pytest.LogCaptureFixture):
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><geom size='0.1'/></body></worldbody></mujoco>"
    )
    physics = NativePhysics(model, 64, num_threads=4)
    physics._warnings[:] = 0  # MuJoCo then prints what it counts
    physics.write("qpos", float("nan"))
    physics.step(5)
    texts = [record.message for record in caplog.records if record.message.startswith("MuJoCo: ")]
    assert "unstable" in texts[0]
    assert len(texts) < 10  # of nearly 200


@pytest.mark.usefixtures("throttle")
def test_a_handler_of_the_user_stays():
    texts: list[str] = []
    mujoco.set_mju_user_warning(texts.append)
    throttle_engine_warnings()
    _mujoco_warning("mine", 1)
    assert texts == ["mine"]


def test_an_engine_that_runs_writes_neither_to_the_console_nor_to_a_file(tmp_path: Path):
    code = """
import ctypes, pathlib, mujoco
from lift_lab.sim.physics import make_physics
physics = make_physics(mujoco.MjModel.from_xml_string("<mujoco/>"), 2, "cpu", "native", num_threads=2)
folder = pathlib.Path(mujoco.__file__).parent
library = ctypes.CDLL(str(next(folder.glob("*mujoco*.so*"), None) or next(folder.glob("*mujoco*.d*"))))
for _ in range(1000):
    library.mju_warning(b"Linesearch objective is not convex")
physics.step()
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    assert len([line for line in done.stderr.splitlines() if "Linesearch" in line]) == 4
    assert not list(tmp_path.iterdir())
