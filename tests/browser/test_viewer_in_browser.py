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


@pytest.fixture(scope="module")
def viewer():
    """A running play.py --viewer of four environments, without a display; its address."""
    command = [*PLAY, *SCRIPTED, "--viewer", "--port", "0", "--num_envs", "4", "env.episode_length_s=600"]
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


def open_page(page, url: str) -> None:
    """Load the page of the viewer."""
    page.goto(url, wait_until="commit")
    page.locator("[role=slider]").first.wait_for()
    page.locator("canvas[data-engine]").wait_for()
    hide_notices(page)


def test_the_viewer_shows_a_robot_that_moves_and_a_slider_moves_the_goal(page, viewer):
    open_page(page, viewer)
    first = wait_for(lambda: drawn(page, "live"), "the table is on screen")
    text = page.locator("body").inner_text()
    for expected in ("Lift-Cube-Franka-CL-Play", "random", "environment 0 of 4", "object_pose"):
        assert expected in text

    # the random agent moves the robot, which is in the middle of the picture
    assert wait_for(lambda: differing(first, see(page, "live_later")).mean() > 0.003, "the robot moves")
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


def press(page, element) -> None:
    """Click an element at once: Playwright's own click waits until a slow renderer has drawn two frames."""
    box = element.bounding_box()
    page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.evaluate("document.activeElement.blur()")  # a tab that has the focus takes the space key


def panel_text(page) -> str:
    return page.locator("body").inner_text()


def is_paused(page) -> bool:
    return page.get_by_role("button", name="Go on").count() > 0


def pause(page, paused: bool) -> None:
    """Pause the simulation or let it go on, with the key."""
    press(page, page.get_by_text("Run", exact=True))
    wait_for(lambda: page.get_by_role("button", name="Reset", exact=True).count() > 0, "the tab Run is shown")
    if is_paused(page) != paused:
        page.keyboard.press("Space")
        wait_for(lambda: is_paused(page) == paused, f"space makes paused {paused}")


def standing(page, name: str) -> np.ndarray:
    """A picture that stays the same."""
    return wait_for(lambda: settled(page, name), "the scene stands")


def cube_at(picture: np.ndarray):
    """Column and row of the cube, the only thing that is colourful; None if it is not seen."""
    colourful = vivid(picture)
    colourful[-80:, :80] = colourful[:, -12:] = False  # viser's own axes, and the edge of the panel
    places = np.argwhere(colourful)
    return places.mean(axis=0)[::-1] if 10 < len(places) < 160 else None


def triangles(page) -> int:
    """Triangles that the browser drew in its last frame."""
    return page.evaluate("window.__viserTestpoints.rendererInfo.render.triangles")


def last_time_plotted(page) -> float:
    return page.evaluate(
        "Object.values(window.__viserTestpoints.uplots ?? {}).map(u => u.chart.data[0].at(-1))[0] ?? -1"
    )


def weight_on_table(page) -> float | None:
    """Force in N between cube and table, as the page lists it."""
    found = re.search(r"object/Object ← table/Table\s+4\s+([\d.]+) N", panel_text(page))
    return float(found[1]) if found else None


CUBE_KG = 0.2


def test_controls_of_the_view_do_what_they_say(page, viewer):
    open_page(page, viewer)
    wait_for(lambda: drawn(page, "controls"), "the table is on screen")
    page.keyboard.press("V")
    all_envs = triangles(page)
    page.keyboard.press("i")
    wait_for(lambda: triangles(page) < all_envs / 2, "three of four environments are hidden")
    page.keyboard.press("m")
    # it lies still after half a second; then colours belong to the cube alone
    pause(page, False)
    wait_for(lambda: cube_at(see(page, "no_markers")) is not None, "the goal's frame is hidden")
    pause(page, True)
    plain = standing(page, "plain")

    page.keyboard.press("l")
    wait_for(lambda: differing(plain, see(page, "colliders")).mean() > 0.1, "colliders are drawn")
    tint = standing(page, "colliders") - plain
    assert (tint[..., 0] - tint[..., 2])[differing(plain, plain + tint)].mean() > 10  # orange
    page.keyboard.press("l")
    page.keyboard.press("x")
    wait_for(lambda: (vivid(new := see(page, "frames")) & differing(new, plain)).sum() > 100, "axes are drawn")
    page.keyboard.press("x")
    wait_for(lambda: cube_at(see(page, "plain_again")) is not None, "axes are gone")
    assert differing(plain, see(page, "plain_again")).mean() < 0.05

    page.keyboard.press("c")
    press(page, page.get_by_text("Values", exact=True))
    weight = wait_for(lambda: weight_on_table(page), "the force on the cube is listed")
    assert weight == pytest.approx(CUBE_KG * 9.81, rel=0.03)
    contacts = standing(page, "contacts")
    green = contacts[..., 1] - np.maximum(contacts[..., 0], contacts[..., 2]) > 30
    assert (green & differing(plain, contacts)).sum() > 10

    page.keyboard.press("c")
    wait_for(lambda: "contact: on" not in panel_text(page), "contacts are gone")

    # the mouse lifts the cube from the table
    press(page, page.get_by_text("Run", exact=True))
    column, row = cube_at(standing(page, "before_pull"))
    page.keyboard.down("Control")
    page.mouse.move(column, row)
    page.mouse.down()
    page.mouse.move(column, row - 70, steps=4)
    wait_for(lambda: "pulling object/Object of environment 0 with" in panel_text(page), "the mouse pulls")
    page.get_by_role("button", name="Go on").evaluate("button => button.click()")
    wait_for(lambda: is_above(cube_at(see(page, "pulled")), row - 30), "the cube is in the air")
    page.mouse.up()
    page.keyboard.up("Control")
    wait_for(lambda: "pulling" not in panel_text(page), "the mouse lets go")
    wait_for(lambda: not is_above(cube_at(see(page, "let_go")), row - 30), "the cube falls")

    # curves go on with the simulation, and a step is one environment step
    press(page, page.get_by_text("Plots", exact=True))
    begin = wait_for(lambda: max(0.0, last_time_plotted(page)), "rewards are plotted")
    wait_for(lambda: last_time_plotted(page) > begin, "the curves go on")
    pause(page, True)
    press(page, page.get_by_text("Plots", exact=True))
    end = wait_for(lambda: max(0.0, last_time_plotted(page)), "rewards are plotted")
    page.keyboard.press("o")
    wait_for(lambda: last_time_plotted(page) > end, "one step is plotted")
    assert last_time_plotted(page) == pytest.approx(end + 0.02, abs=1e-6)

    # the cube stays in the middle of the picture wherever a reset puts it
    press(page, page.get_by_text("View", exact=True))
    page.get_by_label("Follow", exact=True).click()
    page.get_by_role("option", name="object/Object", exact=True).click()  # it scrolls there first
    page.evaluate("document.activeElement.blur()")
    middle = np.array((SIZE["width"] / 2, SIZE["height"] / 2))
    for name in ("follow", "follow_after_reset"):
        wait_for(lambda name=name: is_near(cube_at(see(page, name)), middle), "the cube is in the middle")
        followed = standing(page, name)
        page.keyboard.press("r")
        wait_for(lambda old=followed, name=name: differing(old, see(page, name)).mean() > 0.01, "a reset moves things")
    page.keyboard.press("v")
    wait_for(lambda: not is_near(cube_at(see(page, "view")), middle), "the view is reset")


def is_above(place, row: float) -> bool:
    """Whether a place in the picture is known and above a row."""
    return place is not None and bool(place[1] < row)


def is_near(place, other: np.ndarray) -> bool:
    """Whether a place in the picture is known and close to another."""
    return place is not None and bool(np.linalg.norm(place - other) < 12)


def test_a_replay_page_plays_without_a_server(page, tmp_path):
    file = tmp_path / "replay.html"
    command = [*PLAY, *SCRIPTED, "--num_envs", "1", "--steps", "50", "--replay", file]
    subprocess.run([str(part) for part in command], check=True, env=HEADLESS)
    page.goto(file.as_uri(), wait_until="commit")
    page.locator("canvas[data-engine]").wait_for()
    hide_notices(page)
    first = wait_for(lambda: drawn(page, "replay"), "the table is on screen")
    assert wait_for(lambda: differing(first, see(page, "replay_later")).mean() > 0.003, "the replay plays")
