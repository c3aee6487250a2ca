"""Videos come out whole, with the frames that went in, or not at all; and no one dies of them."""

import importlib.util
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest

from lift_lab_rl import video
from lift_lab_rl.video import RecordVideo, VideoError, VideoWriter

av = pytest.importorskip("av")


def frames(path):
    with av.open(str(path)) as container:
        return [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]


def test_every_frame_is_in_the_file_and_no_other_file_is_left(tmp_path):
    writer = VideoWriter(tmp_path / "a" / "v.mp4", fps=50)
    for value in (0, 100, 200):
        writer.add(np.full((32, 48, 3), value, dtype=np.uint8))
    assert not (tmp_path / "a" / "v.mp4").exists()
    assert writer.close() == tmp_path / "a" / "v.mp4"
    assert [path.name for path in (tmp_path / "a").iterdir()] == ["v.mp4"]
    assert [round(float(frame.mean()), -1) for frame in frames(tmp_path / "a" / "v.mp4")] == [0.0, 100.0, 200.0]


def test_a_frame_with_odd_sides_loses_a_row_and_a_column(tmp_path):
    writer = VideoWriter(tmp_path / "v.mp4", fps=50)
    writer.add(np.zeros((33, 49, 3), dtype=np.uint8))
    assert frames(writer.close())[0].shape == (32, 48, 3)


def test_a_video_without_frames_leaves_no_file(tmp_path):
    assert VideoWriter(tmp_path / "v.mp4", fps=50).close() is None
    assert list(tmp_path.iterdir()) == []


def test_a_missing_encoder_is_named_with_the_way_to_install_it(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(VideoError, match=r"pip install 'lift-lab\[video\]'"):
        VideoWriter(tmp_path / "v.mp4", fps=50)


class StillEnv(gym.Env):
    """Does nothing."""

    metadata = {"render_fps": 50.0}

    def step(self, action):
        return None, 0.0, False, False, {}


class FakeFilm:
    """A film whose file lists how many frames it is of."""

    def __init__(self, frames):
        self.frames = frames

    def save(self, path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(str(len(self.frames)))


class FakeCapture:
    """Sees numbers."""

    def __init__(self, env):
        self.count = 0

    def frame(self):
        self.count += 1
        return self.count

    def film(self, frames, fps):
        return FakeFilm(frames)


DRAW = "import os, sys; os.replace(sys.argv[1], sys.argv[2])"
"""Draws a film by renaming it."""


@pytest.fixture
def record(tmp_path, monkeypatch):
    """Makes a recorder whose drawing process runs the code it is given; what it says is in its ``said``."""
    monkeypatch.setattr(video, "FrameCapture", FakeCapture)
    codes = [DRAW]

    def start(source, target, background):
        return subprocess.Popen([sys.executable, "-S", "-c", codes[0], source, target], stderr=subprocess.PIPE)

    monkeypatch.setattr(video.film, "start", start)

    def make(interval, length, code=DRAW):
        codes[0] = code
        said = []
        env = RecordVideo(StillEnv(), lambda k: tmp_path / f"step_{k}.mp4", interval, length, say=said.append)
        env.said = said
        return env

    return make


def test_the_first_steps_of_every_interval_are_filmed(record, tmp_path):
    env = record(interval=5, length=2)
    for _ in range(11):
        env.step(None)
    env.close()
    assert [path.name for path in env.files] == ["step_0.mp4", "step_5.mp4", "step_10.mp4"]
    assert [path.read_text() for path in env.files] == ["2", "2", "1"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["step_0.mp4", "step_10.mp4", "step_5.mp4"]
    assert env.problem is None


@pytest.mark.parametrize(
    ("code", "reason"),
    [
        ("import sys; sys.exit('libEGL warning\\nno OpenGL library was found')", "no OpenGL library was found"),
        ("import os; os.kill(os.getpid(), 9)", "ended by SIGKILL"),
        ("import sys; sys.exit(5)", "ended with status 5"),
    ],
)
def test_a_film_that_cannot_be_drawn_is_said_once_and_nothing_is_filmed_from_then_on(record, tmp_path, code, reason):
    env = record(interval=2, length=1, code=code)
    env.step(None)
    env._drawing[0].wait()
    for _ in range(6):
        env.step(None)
    env.close()
    (line,) = env.said
    assert line.startswith("warning: ")
    assert reason in line
    assert line.endswith("no more videos")
    assert list(tmp_path.iterdir()) == []
    assert env.files == []


def test_a_disk_that_is_full_ends_filming_and_nothing_else(record, monkeypatch):
    env = record(interval=2, length=1)

    def full(self, path):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(FakeFilm, "save", full)
    for _ in range(5):
        env.step(None)
    env.close()
    (line,) = env.said
    assert "No space left on device" in line


def test_films_are_drawn_one_after_the_other(record):
    env = record(interval=1, length=1, code="import time; time.sleep(0.3); " + DRAW)
    for _ in range(3):
        env.step(None)
    assert env._drawing is not None
    assert len(env._waiting) == 2
    env.close()
    assert len(env.files) == 3
    assert env.said[0].startswith("drawing ")


def test_lengths_that_are_not_positive_are_refused(record):
    with pytest.raises(VideoError, match="must be positive"):
        record(interval=0, length=1)
