"""Lights of a drawn scene, and the choice of an OpenGL library."""

import os
import subprocess
import sys

import mujoco
import numpy as np
import pytest

from lift_lab.drawing import opengl
from lift_lab.drawing.framing import View, fit
from lift_lab.drawing.opengl import DrawError
from lift_lab.drawing.scene import Picture, SceneDrawer

HEIGHT, WIDTH = 90, 160
MODEL = """
<mujoco>
  <visual><headlight active="0"/></visual>
  <asset>
    <texture name="plain" type="2d" builtin="flat" rgb1="1 1 1" width="8" height="8"/>
    <material name="floor" texture="plain"/>
  </asset>
  <worldbody>
    {light}
    <geom type="plane" size="5 5 1" material="floor"/>
    <body pos="0 0 .5"><joint type="slide" axis="1 0 0"/><geom type="box" size=".2 .2 .2" rgba="1 1 1 1"/></body>
  </worldbody>
</mujoco>
"""
LAMP = '<light type="directional" dir="0 0 -1" diffuse="{}" ambient="0.1 0 0" specular="0 0 0"/>'


def draw(light=""):
    """The frame, and whether each of its pixels is below the horizon."""
    model = mujoco.MjModel.from_xml_string(MODEL.format(light=light))
    view = View(lookat=(0.0, 0.0, 0.4), distance=2.5, azimuth_deg=90.0, elevation_deg=-30.0)
    try:
        drawer = SceneDrawer(model, WIDTH, HEIGHT, np.zeros((1, 3)))
    except DrawError as error:
        pytest.skip(str(error))
    frame = drawer.draw(Picture(np.zeros((1, 1)), np.zeros((1, 0, 3)), np.zeros((1, 0, 4)), view)).astype(int)
    drawer.close()
    return frame[HEIGHT // 3 :]


def test_a_scene_without_a_light_is_bright_and_has_shadows():
    floor = draw()
    assert floor.mean() > 130
    dark = floor.mean(axis=2) < 0.75 * np.median(floor.mean(axis=2))
    assert 0.01 < dark.mean() < 0.3


def test_a_scene_with_a_light_is_lit_by_that_light_alone():
    red = draw(LAMP.format("0.8 0 0"))
    near = red[-HEIGHT // 3 :]  # no haze there
    assert near[..., 0].max() > 150
    assert near[..., 1:].max() == 0


def test_drawing_does_not_change_the_model():
    model = mujoco.MjModel.from_xml_string(MODEL.format(light=""))
    before = np.empty(mujoco.mj_sizeModel(model), dtype=np.uint8)
    after = before.copy()
    mujoco.mj_saveModel(model, None, before)
    try:
        drawer = SceneDrawer(model, WIDTH, HEIGHT, np.zeros((1, 3)), fine=True)
    except DrawError as error:
        pytest.skip(str(error))
    drawer.draw(Picture(np.zeros((1, 1)), np.zeros((1, 0, 3)), np.zeros((1, 0, 4))))
    drawer.close()
    mujoco.mj_saveModel(model, None, after)
    assert np.array_equal(before, after)


@pytest.mark.parametrize("aspect", [0.5, 16 / 9])
@pytest.mark.parametrize("size", [1e-3, 1.0, 40.0])
def test_the_camera_sees_every_point_and_one_side_is_as_full_as_asked(aspect, size):
    points = size * (np.random.default_rng(3).uniform(-1, 1, (50, 3)) + np.array((5.0, -2.0, 0.5)))
    view = fit(points, aspect, fov_deg=40.0, fill=0.6)
    # a pinhole camera, written out
    azimuth, elevation = np.radians((view.azimuth_deg, view.elevation_deg))
    ahead = np.array((np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)))
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    seen = points - (np.array(view.lookat) - view.distance * ahead)
    depth = seen @ ahead
    x = seen @ right / depth / (aspect * np.tan(np.radians(20)))
    y = seen @ np.cross(right, ahead) / depth / np.tan(np.radians(20))
    assert depth.min() > 0
    assert max(abs(x).max(), abs(y).max()) == pytest.approx(0.6, rel=1e-4)


# -- libraries

RENDER = """
import mujoco, numpy as np
from lift_lab.drawing.scene import Picture, SceneDrawer
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>")
try:
    drawer = SceneDrawer(model, 32, 24, np.zeros((1, 3)))
    print(drawer.draw(Picture(np.zeros((1, 0)), np.zeros((1, 0, 3)), np.zeros((1, 0, 4)))).shape)
except Exception as error:
    print(type(error).__name__, error)
"""


def printed(code, **variables):
    """What a new process prints, in an environment with nothing but what Python needs and some variables."""
    kept = {name: os.environ[name] for name in ("PATH", "PYTHONPATH", "HOME") if name in os.environ}
    done = subprocess.run(
        [sys.executable, "-c", code], env=kept | variables, capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout.strip()


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL is Linux's")
def test_frames_are_drawn_without_a_display_and_without_setting_a_variable(tmp_path):
    shown = printed(RENDER)
    if "no OpenGL library was found" in shown:
        pytest.skip(shown)
    assert shown == "(24, 32, 3)"


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL is Linux's")
def test_without_a_library_one_line_names_the_packages(tmp_path):
    for name in ("libEGL.so", "libEGL.so.1"):  # found first, and no libraries
        (tmp_path / name).write_bytes(b"")
    shown = printed(RENDER, LD_LIBRARY_PATH=str(tmp_path))
    assert shown.startswith("DrawError no OpenGL library was found; on Debian or Ubuntu: apt-get install libegl1 ")
    assert shown.count("\n") == 0


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="EGL is Linux's")
def test_a_command_answers_in_one_line_where_the_users_library_is_missing(tmp_path):
    for name in ("libEGL.so", "libEGL.so.1"):
        (tmp_path / name).write_bytes(b"")
    kept = {name: os.environ[name] for name in ("PATH", "PYTHONPATH", "HOME") if name in os.environ}
    kept |= {"LD_LIBRARY_PATH": str(tmp_path), "MUJOCO_GL": "egl"}
    command = [sys.executable, "-m", "lift_lab_cli", "play", "--task", "Cartpole"]
    done = subprocess.run(command, env=kept, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert done.stderr.startswith("error: mujoco cannot be imported with MUJOCO_GL=egl (")
    assert "unset MUJOCO_GL, or on Debian or Ubuntu: apt-get install libegl1" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("glfw", "MUJOCO_GL=glfw needs a display, and there is none: unset it"),
        ("off", "MUJOCO_GL=off switches"),
        ("eggl", "MUJOCO_GL=eggl is none of egl, osmesa, cgl, glfw"),
    ],
)
def test_the_users_choice_of_a_library_is_obeyed(monkeypatch, value, message):
    monkeypatch.setenv("MUJOCO_GL", value)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if not sys.platform.startswith("linux"):
        monkeypatch.setattr(opengl, "has_display", lambda: False)
    with pytest.raises(DrawError, match=message):
        opengl.open_context(32, 24)
