"""Policies and films in scripts and notebooks."""

import base64
import io

import gymnasium as gym
import numpy as np
import pytest
import torch

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_assets.files import PRETRAINED_DIR
from lift_lab_rl.rsl_rl import RslRlVecEnvWrapper
from lift_lab_rl.video import VideoError, show_video
from lift_lab_tasks.utils import load_policy


@pytest.fixture(scope="module")
def env():
    env = gym.make("Cartpole", num_envs=2, device="cpu")
    yield env
    env.close()


def test_the_policy_that_ships_acts_as_its_onnx_file_does(env):
    onnxruntime = pytest.importorskip("onnxruntime")
    policy = load_policy(env)
    obs, _ = env.reset(seed=3)
    session = onnxruntime.InferenceSession(PRETRAINED_DIR / "Cartpole" / "policy.onnx")
    wanted = [session.run(["actions"], {"obs": row[None].numpy()})[0][0] for row in obs["policy"]]
    assert policy(obs).numpy() == pytest.approx(np.stack(wanted), abs=1e-5)


def test_what_cannot_be_loaded_is_said(env, tmp_path):
    with pytest.raises(FileError, match=r"model_7\.pt"):
        load_policy(env, str(tmp_path / "model_7.pt"))
    with pytest.raises(ConfigError, match=r"gym\.make"):
        load_policy(gym.Env())  # of no registered task


@pytest.mark.parametrize("wrapped", [False, True])
def test_a_film_is_shown_where_it_is_the_value_of_a_cell(env, tmp_path, wrapped):
    av = pytest.importorskip("av")
    seen = []

    def policy(obs):
        seen.append(obs["policy"].clone())
        return torch.ones(2, 1)

    try:
        video = show_video(RslRlVecEnvWrapper(env) if wrapped else env, policy, steps=4, resolution=(64, 48))
    except VideoError as error:
        if "no OpenGL library was found" in str(error):
            pytest.skip(str(error))
        raise
    assert len(seen) == 4
    assert not torch.equal(seen[0], seen[3])
    with av.open(io.BytesIO(video.data)) as container:
        stream = container.streams.video[0]
        assert (stream.width, stream.height, stream.average_rate) == (64, 48, 30)  # of 60 steps per second
        assert sum(1 for _ in container.decode(stream)) == 3
    html = video._repr_html_()
    assert html.startswith("<video ")
    assert base64.b64decode(html.partition("base64,")[2].partition('"')[0]) == video.data
    assert video.save(tmp_path / "a.mp4").read_bytes() == video.data


def test_a_film_of_no_steps_is_refused(env):
    pytest.importorskip("av")
    with pytest.raises(VideoError, match="steps must be positive, got 0"):
        show_video(env, steps=0)
