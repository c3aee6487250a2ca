"""A real browser shows the viewer and the replay page. What it saw is kept in build/browser (or LIFT_LAB_ARTEFACTS)."""

import contextlib
import io
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

pytest.importorskip("viser")
playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed (the extra 'dev')")

ROOT = Path(__file__).resolve().parents[2]
ARTEFACTS = Path(os.environ.get("LIFT_LAB_ARTEFACTS", ROOT / "build" / "browser"))
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
PLAY = [sys.executable, ROOT / "scripts" / "rsl_rl" / "play.py", "--task", "Lift-Cube-Franka-CL-Play"]
SCRIPTED = ["--agent", "random", "--device", "cpu", "--num_threads", "1"]
SIZE = {"width": 720, "height": 360}
PATIENCE_S = float(os.environ.get("LIFT_LAB_BROWSER_PATIENCE", 90))
"""A software renderer on a busy machine takes its time."""
HEADLESS = {
    name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY", "MUJOCO_GL")
}
HEADLESS["OMP_NUM_THREADS"] = "1"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="there is no chromium on PATH"),
]


@pytest.fixture(scope="module")
def browser():
    """Chromium without a display and without a GPU."""
    flags = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with playwright.sync_playwright() as program:
        chromium = program.chromium.launch(executable_path=CHROMIUM, args=flags, timeout=PATIENCE_S * 1e3)
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser):
    """An empty page; fails if anything outside this machine was asked for."""
    page = browser.new_page(viewport=SIZE)
    page.set_default_timeout(PATIENCE_S * 1e3)
    outside = []
    inside = re.compile(r"(https?|ws)://127\.0\.0\.1|file:|data:|blob:")
    page.on("request", lambda request: inside.match(request.url) or outside.append(request.url))
    yield page
    page.close()
    assert outside == []


@contextlib.contextmanager
def viewer(*args):
    """A running play.py --viewer, without a display; its address."""
    command = [*PLAY, *SCRIPTED, "--viewer", "--port", "0", *args]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=HEADLESS)
    try:
        for line in process.stdout:
            if line.startswith("viewer: "):
                break
        yield re.search(r"http://\S+", line)[0]
    finally:
        process.send_signal(signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.communicate(timeout=PATIENCE_S)
        process.kill()
    assert process.returncode == 0


def see(page, name: str) -> np.ndarray:
    """The scene left of the panel, below the notice about software rendering; integers, shape (height, width, 3)."""
    data = page.screenshot()
    ARTEFACTS.mkdir(parents=True, exist_ok=True)
    (ARTEFACTS / f"{name}.png").write_bytes(data)
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)[:, : SIZE["width"] - 330]


def wait_for(what, describe: str):
    """The first picture or true value of ``what()``."""
    until = time.monotonic() + PATIENCE_S
    while time.monotonic() < until:
        found = what()
        if isinstance(found, np.ndarray) or found:
            return found
        time.sleep(0.3)
    pytest.fail(f"not within {PATIENCE_S:g} s: {describe}")


def differing(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Which pixels differ by more than rounding."""
    return np.abs(one - other).max(axis=-1) > 24


def vivid(picture: np.ndarray) -> np.ndarray:
    """Which pixels are as colourful as the axes of a frame."""
    return picture.max(axis=-1) - picture.min(axis=-1) > 90


def is_drawn(picture: np.ndarray) -> bool:
    """The table's top fills much of the scene, and what is black (it fades in from white) is there."""
    table = (picture[..., 0] - picture[..., 2] > 20) & (picture[..., 0] > 90)
    return table.mean() > 0.05 and (picture.max(axis=-1) < 60).mean() > 0.002


def drawn(page, name: str):
    """A picture with the scene in it, None while it is still empty."""
    picture = see(page, name)
    return picture if is_drawn(picture) else None


def hide_notices(page) -> None:
    """Notices (rendering in software, a lost connection) lie over the scene whenever they like: they are not drawn."""
    page.add_style_tag(content=".mantine-Notifications-root { display: none !important; }")


def test_the_viewer_shows_a_robot_that_moves_and_a_slider_moves_the_goal(page):
    with viewer("--num_envs", "4") as url:
        page.goto(url, wait_until="commit")
        sliders = page.locator("[role=slider]")
        sliders.first.wait_for()
        page.locator("canvas[data-engine]").wait_for()
        hide_notices(page)
        first = wait_for(lambda: drawn(page, "live"), "the table is on screen")
        body = page.locator("body")
        text = body.inner_text()
        for expected in ("Lift-Cube-Franka-CL-Play", "random", "environment 0 of 4", "object_pose"):
            assert expected in text

        # the random agent moves the robot, which is in the middle of the picture
        moved = wait_for(lambda: differing(first, see(page, "live_later")).mean() > 0.003, "the robot moves")
        assert moved
        page.get_by_text("Pause", exact=True).click()
        page.get_by_text("Go on", exact=True).wait_for()
        wait_for(lambda: not differing(see(page, "paused"), see(page, "paused_later")).any(), "pause holds the robot")

        # y of the goal at one end of its range, then at the other. Only the goal's frame moves, once a slow renderer
        # has drawn the robot's last pose and has settled on a resolution
        wait_for(lambda: only_a_frame_moves(*(goal_at(page, *end) for end in ENDS)), "only the goal's frame moves")


ENDS = (("End", "0.25"), ("Home", "-0.25"))


def goal_at(page, key: str, value: str) -> np.ndarray:
    """The scene with the goal's y moved to an end of its range by a key."""
    page.locator("[role=slider]").nth(1).press(key)
    figures = re.compile(rf"object_pose\s+\S+\s+{value}")
    wait_for(lambda: figures.search(page.locator("body").inner_text()) is not None, f"the goal's y is {value}")
    return wait_for(lambda: settled(page, f"goal_{key}"), "the scene stands")


def only_a_frame_moves(old: np.ndarray, new: np.ndarray) -> bool:
    """Whether the axes of a frame are at another place, and little else differs."""
    changed = differing(old, new)
    if not 0 < changed.mean() < 0.02:
        return False
    places = [np.argwhere(vivid(picture) & changed) for picture in (old, new)]
    return min(map(len, places)) > 20 and bool(np.linalg.norm(np.subtract(*(at.mean(axis=0) for at in places))) > 5)


def settled(page, name: str):
    """A picture that the next one equals."""
    one, other = see(page, name), see(page, name)
    return None if differing(one, other).any() else other


def test_a_replay_page_plays_without_a_server(page, tmp_path):
    file = tmp_path / "replay.html"
    command = [*PLAY, *SCRIPTED, "--num_envs", "1", "--steps", "50", "--replay", file]
    subprocess.run([str(part) for part in command], check=True, env=HEADLESS)
    page.goto(file.as_uri(), wait_until="commit")
    page.locator("canvas[data-engine]").wait_for()
    hide_notices(page)
    first = wait_for(lambda: drawn(page, "replay"), "the table is on screen")
    assert wait_for(lambda: differing(first, see(page, "replay_later")).mean() > 0.003, "the replay plays")
