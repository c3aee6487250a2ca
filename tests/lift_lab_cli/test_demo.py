"""The demo shows a pretrained policy in a browser or in a film, and leaves nothing else behind."""

import importlib.util
import sys
import webbrowser

import gymnasium as gym
import pytest
import torch
from gymnasium.envs.registration import EnvSpec

from lift_lab.app import cli
from lift_lab_cli import demo


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    """Runs the demo in an empty folder; returns exit status, output and errors."""
    threads = torch.get_num_threads()
    monkeypatch.chdir(tmp_path)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)

    def run(*args):
        monkeypatch.setattr(sys, "argv", ["lift-lab demo", *map(str, args)])
        with pytest.raises(SystemExit) as ended:
            cli.run(demo.main)
        captured = capsys.readouterr()
        return ended.value.code, captured.out, captured.err

    yield run
    torch.set_num_threads(threads)


@pytest.fixture
def without(monkeypatch):
    """Makes packages look as if they were not installed."""
    find = importlib.util.find_spec

    def hide(*names):
        monkeypatch.setattr(importlib.util, "find_spec", lambda name, *a: None if name in names else find(name, *a))

    return hide


SMALL = ("--task", "Cartpole", "--device", "cpu", "--num_envs", 2, "--steps", 2)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["--task", "Lift-Cube-Frank"], "unknown task 'Lift-Cube-Frank'; did you mean 'Lift-Cube-Franka'"),
        (["--task", "Own-Task"], "no pretrained policy for 'Own-Task'; tasks that have one: Cartpole, "),
        (["--video", "film.avi"], "--video: expected a file ending in .mp4, got 'film.avi'"),
        (["--video", "--port", "0"], "--video writes a film, and --port is for the browser: give one"),
        (["--video", "--viewer"], "--video writes a film, and --viewer is for the browser: give one"),
        (["--port", "70000"], "port 70000 is no port"),
        (["--num_envs", "0"], "at least 1, got '0'"),
        (["--vidio"], "unknown flag '--vidio'; did you mean --video"),
        (["--video", "missing/deep/../../x/", "a"], "--video: expected a file ending in .mp4"),
    ],
)
def test_what_cannot_work_is_one_line_and_writes_nothing(call, tmp_path, monkeypatch, args, message):
    own = EnvSpec("Own-Task", kwargs={"env_cfg_entry_point": "my_tasks:Cfg"})
    monkeypatch.setitem(gym.registry, own.id, own)
    status, out, err = call(*args)
    assert (status, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_without_viewer_and_film_packages_the_error_names_the_extra(call, without):
    without("viser", "av")
    status, _, err = call()
    assert status == 2
    assert "pip install 'lift-lab[all]'" in err


def test_the_browser_is_opened_where_there_is_a_display(call, monkeypatch, tmp_path):
    pytest.importorskip("viser")
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda address: bool(opened.append(address)))
    monkeypatch.setenv("DISPLAY", ":7")
    monkeypatch.setattr("lift_lab.visualizers.is_free", lambda port: False)  # so that any free port is taken
    status, out, _ = call(*SMALL)
    assert status == 0
    assert f"viewer: {opened[0]} (Ctrl-C ends it)" in out
    assert opened[0].startswith("http://127.0.0.1:")
    assert not opened[0].endswith(":8080")
    assert "no browser was found: open the address by hand" in out
    assert "2 steps of 2 environments" in out
    assert not list(tmp_path.iterdir())


def test_a_port_asks_for_the_page_also_without_a_display(call, monkeypatch, tmp_path):
    pytest.importorskip("viser")
    monkeypatch.setattr(webbrowser, "open", lambda address: pytest.fail("there is no display"))
    status, out, _ = call("--port", 0, *SMALL)
    assert status == 0
    assert "viewer: http://127.0.0.1:" in out
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("has_viewer", [True, False])
def test_without_a_display_or_viewer_it_is_a_film(call, without, monkeypatch, tmp_path, has_viewer):
    pytest.importorskip("av")
    if not has_viewer:
        without("viser")
        monkeypatch.setenv("DISPLAY", ":7")
    status, out, err = call(*SMALL, "env.episode_length_s=0.02", "env.viewer.resolution=[64,48]")
    if "no OpenGL library was found" in err:
        pytest.skip("no OpenGL library")
    assert (status, err) == (0, "")
    reason = "there is no display" if has_viewer else "viser is not installed (pip install 'lift-lab[viewer]')"
    assert out.startswith(f"writing a film, because {reason}")
    assert "success: in 0 of 2 environments\n2 frames are drawn" in out
    assert out.endswith("film: lift_demo.mp4\n")
    assert [path.name for path in tmp_path.iterdir()] == ["lift_demo.mp4"]
    import av

    with av.open("lift_demo.mp4") as film:
        stream = film.streams.video[0]
        assert (stream.width, stream.height) == (64, 48)
        assert sum(1 for _ in film.decode(stream)) == 2


def test_a_film_that_cannot_be_drawn_is_one_line(call, monkeypatch, tmp_path):
    pytest.importorskip("av")
    monkeypatch.setenv("MUJOCO_GL", "disable")  # this process has imported mujoco; the one that draws has not
    status, _, err = call("--video", "a.mp4", *SMALL)
    assert status == 2
    assert err.startswith("error: 'a.mp4' could not be drawn: ")
    assert err.endswith("; lift-lab demo --viewer needs only a browser\n")
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_goals_change_often_unless_the_user_says_how_often():
    import lift_lab_tasks  # noqa: F401

    goals = ["env.commands.object_pose.resampling_time_range=[1.6,1.6]"]
    assert demo.goal_overrides("Lift-Cube-Franka-CL", ["env.seed=1"]) == goals
    assert demo.goal_overrides("Lift-Cube-Franka-CL", ["env.commands.object_pose.resampling_time_range=[3,4]"]) == []
    assert demo.goal_overrides("Cartpole", []) == []
