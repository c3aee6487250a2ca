"""Videos come out whole, with the frames that went in, or not at all."""

import importlib.util

import gymnasium as gym
import numpy as np
import pytest

from lift_lab_rl.video import RecordVideo, VideoError, VideoWriter

av = pytest.importorskip("av")


class FrameEnv(gym.Env):
    """Draws a brighter frame at every step."""

    metadata = {"render_fps": 50.0}

    def __init__(self):
        self.steps = 0

    def step(self, action):
        self.steps += 1
        return None, 0.0, False, False, {}

    def render(self):
        return np.full((32, 48, 3), min(255, 20 * self.steps), dtype=np.uint8)


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


def test_a_video_without_frames_leaves_no_file(tmp_path):
    assert VideoWriter(tmp_path / "v.mp4", fps=50).close() is None
    assert list(tmp_path.iterdir()) == []


def test_the_first_steps_of_every_interval_are_recorded(tmp_path):
    env = RecordVideo(FrameEnv(), tmp_path, interval=5, length=2)
    for _ in range(11):
        env.step(None)
    env.close()
    assert [path.name for path in env.files] == ["step_0.mp4", "step_5.mp4", "step_10.mp4"]
    assert [len(frames(path)) for path in env.files] == [2, 2, 1]


def test_a_missing_encoder_is_named_with_the_way_to_install_it(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(VideoError, match=r"pip install 'lift-lab\[video\]'"):
        VideoWriter(tmp_path / "v.mp4", fps=50)
