"""gymnasium finds what it expects: spaces, seeds, wrappers, and a VectorEnv from make_vec."""

import sys
from types import ModuleType

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium.utils import seeding
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.wrappers import vector as vector_wrappers

from lift_lab.envs import ManagerBasedRLEnv, ManagerBasedRLVectorEnv
from lift_lab.utils.errors import ConfigError

SIZE = 2 + 7 * 3 + 2  # joints, poses of three bodies, actions


@pytest.fixture
def arm(make_cfg):
    """Registers the arm as a task; returns its id."""
    gym.register(
        id="Arm",
        entry_point="lift_lab.envs:ManagerBasedRLEnv",
        vector_entry_point="lift_lab.envs:ManagerBasedRLVectorEnv",
        disable_env_checker=True,
        kwargs={"env_cfg_entry_point": make_cfg},
    )
    yield "Arm"
    del gym.registry["Arm"]


@pytest.fixture
def opened():
    """Closes what is put into it."""
    made = []
    yield lambda env: made.append(env) or env
    for env in made:
        env.close()


@pytest.fixture
def frames(monkeypatch):
    """Draws without OpenGL: frames that are as bright as there were frames before."""
    drawn = []

    def render(self, recompute=False):
        drawn.append(np.full((8, 8, 3), len(drawn), dtype=np.uint8))
        return drawn[-1]

    monkeypatch.setattr(ManagerBasedRLEnv, "render", render)
    return drawn


@pytest.fixture
def films(monkeypatch):
    """Stands for moviepy, which gymnasium's RecordVideo writes with; holds the frames of each file."""
    written = {}

    class ImageSequenceClip:
        def __init__(self, frames, fps):
            self.frames, self.fps = frames, fps

        def write_videofile(self, path, **kwargs):
            written[path] = self

    clip = ModuleType("moviepy.video.io.ImageSequenceClip")
    clip.ImageSequenceClip = ImageSequenceClip
    for name in ("moviepy", "moviepy.video", "moviepy.video.io"):
        monkeypatch.setitem(sys.modules, name, ModuleType(name))
    monkeypatch.setitem(sys.modules, clip.__name__, clip)
    return written


def test_make_gives_an_environment_whose_observations_are_in_its_spaces(arm, make_cfg, opened):
    env = opened(gym.make(arm, cfg=make_cfg()))
    assert env.unwrapped.single_observation_space["policy"].shape == (SIZE,)
    assert env.observation_space["policy"].shape == (3, SIZE)
    assert env.unwrapped.single_action_space.shape == (2,)
    assert env.action_space.shape == (3, 2)
    assert env.metadata["render_fps"] == pytest.approx(1 / env.unwrapped.step_dt)
    assert env.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    obs, _ = env.reset(seed=1, options={})
    assert env.observation_space.contains({key: value.numpy() for key, value in obs.items()})
    obs, *_ = env.step(torch.as_tensor(env.action_space.sample()))
    assert env.observation_space.contains({key: value.numpy() for key, value in obs.items()})
    assert env.render() is None
    env.close()
    env.close()


def test_gymnasiums_video_wrapper_films_the_first_steps(arm, make_cfg, opened, frames, films, tmp_path):
    env = gym.make(arm, cfg=make_cfg(), render_mode="rgb_array")
    env = opened(gym.wrappers.RecordVideo(env, str(tmp_path), step_trigger=lambda step: step == 0, video_length=3))
    env.reset()
    for _ in range(5):
        env.step(torch.zeros(3, 2))
    (film,) = films.values()
    assert [frame[0, 0, 0] for frame in film.frames] == [0, 1, 2, 3]
    assert film.fps == pytest.approx(50.0)


def test_an_unknown_render_mode_is_named(arm, make_cfg):
    with pytest.raises(ConfigError, match="'rgb_array'"):
        gym.make(arm, cfg=make_cfg(), render_mode="rgb_arry")


class OneEnv(gym.Env):
    """The first environment of a VectorEnv of one, as a single environment, for gymnasium's checker."""

    metadata = {"render_modes": []}
    spec = None

    def __init__(self, vector):
        self.vector = vector
        self.observation_space = vector.single_observation_space
        self.action_space = vector.single_action_space
        self.render_mode = None

    @property
    def np_random_seed(self):
        return self.vector.np_random_seed

    @property
    def _np_random(self):
        return self.vector.np_random

    @_np_random.setter
    def _np_random(self, generator):
        assert generator is None  # what gymnasium's class begins with

    def reset(self, *, seed=None, options=None):
        obs, _ = self.vector.reset(seed=seed, options=options)
        return {key: value[0] for key, value in obs.items()}, {}

    def step(self, action):
        obs, rewards, terminated, truncated, _ = self.vector.step(action[None])
        obs = {key: value[0] for key, value in obs.items()}
        return obs, float(rewards[0]), bool(terminated[0]), bool(truncated[0]), {}


def test_gymnasiums_checker_finds_nothing_wrong(arm, opened, recwarn):
    check_env(OneEnv(opened(gym.make_vec(arm, num_envs=1))), skip_render_check=True)
    told = [str(warning.message) for warning in recwarn if "gymnasium" in warning.filename or "Gym" in str(warning)]
    about_bounds = ("infinity", "symmetric and normalized space", "does not having a spec", "not having a spec")
    assert [text for text in told if not any(part in text for part in about_bounds)] == []


def test_make_without_a_config_makes_the_registered_one(arm, opened):
    env = opened(gym.make(arm))
    assert env.unwrapped.num_envs == 3
    assert env.reset(seed=1)[0]["policy"].shape == (3, SIZE)


def test_a_seed_goes_to_gymnasiums_generator_too(arm, opened):
    expected = seeding.np_random(7)[0].integers(1 << 30, size=5)
    env, envs = opened(gym.make(arm)), opened(gym.make_vec(arm, num_envs=2))
    for made in (env.unwrapped, envs.unwrapped):
        made.reset(seed=7)
        assert made.np_random_seed == 7
        np.testing.assert_array_equal(made.np_random.integers(1 << 30, size=5), expected)
    with pytest.raises(ConfigError, match="seed -2 is not within"):
        env.reset(seed=-2)
    env.reset(seed=-1)  # draws one
    assert env.unwrapped.np_random_seed >= 0


@pytest.mark.parametrize("kind", [torch.tensor, np.array, list, lambda rows: np.array(rows, dtype=np.float64)])
def test_actions_are_tensors_arrays_or_lists(arm, opened, kind):
    env = opened(gym.make(arm))
    rows = [[0.1, -0.2], [0.3, 0.0], [-0.5, 1.0]]
    env.reset(seed=1)
    env.step(kind(rows))
    torch.testing.assert_close(env.unwrapped.action_manager.action, torch.tensor(rows))


@pytest.mark.parametrize(
    ("action", "message"),
    [
        ([[0.1, 0.2]], r"shape \(1, 2\), expected \(3, 2\)"),
        (np.zeros(2), r"shape \(2,\), expected \(3, 2\)"),
        (None, "an action is a tensor, an array or a list of numbers, not NoneType"),
        ("left", "an array or a list of numbers, not str left"),
        ([[0.1], [0.2, 0.3]], "an array or a list of numbers, not list"),
        ({"arm": 1.0}, "an array or a list of numbers, not dict"),
    ],
)
def test_another_action_is_refused_in_one_line(arm, opened, action, message):
    env = opened(gym.make(arm))
    env.reset(seed=1)
    with pytest.raises(ValueError, match=message) as caught:
        env.step(action)
    assert "\n" not in str(caught.value)


def test_make_vec_gives_a_vector_environment_of_numpy_arrays(arm, opened):
    envs = opened(gym.make_vec(arm, num_envs=4))
    assert isinstance(envs, VectorEnv)
    assert isinstance(envs.unwrapped, ManagerBasedRLVectorEnv)
    assert envs.num_envs == 4
    assert envs.spec.id == arm
    assert envs.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    obs, infos = envs.reset(seed=3)
    assert envs.observation_space.contains(obs)
    obs, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
    assert envs.observation_space.contains(obs)
    assert rewards.shape == terminated.shape == truncated.shape == (4,)
    assert rewards.dtype == np.float64
    assert terminated.dtype == truncated.dtype == np.bool_
    assert infos == {}
    assert envs.render() is None
    envs.close()
    envs.close()


def test_the_config_that_is_passed_stays_as_it_is(arm, make_cfg, opened):
    cfg = make_cfg()
    envs = opened(gym.make_vec(arm, num_envs=2, cfg=cfg))
    assert envs.num_envs == 2
    assert cfg.scene.num_envs == 3


def test_one_observation_group_is_handed_out_alone_on_request(arm, opened):
    envs = opened(gym.make_vec(arm, num_envs=2, observation_group="policy"))
    assert envs.single_observation_space.shape == (SIZE,)
    assert envs.reset(seed=1)[0].shape == (2, SIZE)
    with pytest.raises(ConfigError, match="did you mean 'policy'"):
        gym.make_vec(arm, num_envs=2, observation_group="polcy")


def test_a_task_without_a_config_says_so():
    with pytest.raises(ConfigError, match="env_cfg_entry_point"):
        ManagerBasedRLVectorEnv(num_envs=2)


def rollout(envs, seed, steps=3):
    obs, _ = envs.reset(seed=seed)
    seen = [obs["policy"]]
    for step in range(steps):
        obs, *_ = envs.step(np.full((envs.num_envs, 2), 0.1 * step))
        seen.append(obs["policy"])
    return np.stack(seen)


def test_a_seed_repeats_and_another_differs(opened):
    envs = opened(gym.make_vec("lift_lab_tasks:Cartpole", num_envs=3, cfg=_cartpole()))
    actions = np.zeros((3, 1), dtype=np.float32)

    def play(seed):
        first = envs.reset(seed=seed)[0]["policy"]
        return np.stack([first, *(envs.step(actions)[0]["policy"] for _ in range(3))])

    once = play(5)
    np.testing.assert_array_equal(play(5), once)
    assert not np.array_equal(play(6), once)
    with pytest.raises(ConfigError, match="one seed"):
        envs.reset(seed=[1, 2, 3])


def test_a_mask_resets_some_environments_only(opened):
    envs = opened(gym.make_vec("lift_lab_tasks:Cartpole", num_envs=3, cfg=_cartpole()))
    envs.reset(seed=1)
    before, *_ = envs.step(np.zeros((3, 1)))
    after, _ = envs.reset(options={"reset_mask": np.array([False, True, False])})
    same = (before["policy"] == after["policy"]).all(axis=1)
    assert same.tolist() == [True, False, True]
    with pytest.raises(ConfigError, match="boolean array of shape"):
        envs.reset(options={"reset_mask": [True, False, False]})


def test_an_ended_episode_hands_out_its_last_observation_and_the_log(opened):
    cfg = _cartpole()
    going_on = opened(gym.make_vec("lift_lab_tasks:Cartpole", num_envs=2, cfg=cfg))
    cfg.episode_length_s = 2 / 60
    envs = opened(gym.make_vec("lift_lab_tasks:Cartpole", num_envs=2, cfg=cfg))
    actions = np.zeros((2, 1), dtype=np.float32)
    going_on.reset(seed=2)
    going_on.step(actions)
    expected = going_on.step(actions)[0]["policy"]
    envs.reset(seed=2)
    assert envs.step(actions)[4] == {}
    obs, _, terminated, truncated, infos = envs.step(actions)
    assert truncated.all()
    assert not terminated.any()
    assert infos["_final_obs"].all()
    for idx in range(2):
        np.testing.assert_array_equal(infos["final_obs"][idx]["policy"], expected[idx])
    assert not np.array_equal(obs["policy"], expected)
    assert infos["log"]["Episode_Termination/time_out"].tolist() == [1.0, 1.0]


def test_vector_wrappers_of_gymnasium_accept_it(opened, frames, films, tmp_path):
    cfg = _cartpole()
    cfg.episode_length_s = 3 / 60
    task = {"cfg": cfg, "render_mode": "rgb_array", "observation_group": "policy"}
    envs = gym.make_vec("lift_lab_tasks:Cartpole", num_envs=2, **task)
    envs = vector_wrappers.RecordVideo(
        envs, str(tmp_path), episode_trigger=None, step_trigger=lambda step: step == 0, video_length=2,
        record_first_only=True,
    )  # fmt: skip
    envs = vector_wrappers.RecordEpisodeStatistics(envs)
    envs = vector_wrappers.ClipReward(envs, -1.0, 1.0)
    envs = opened(vector_wrappers.DictInfoToList(envs))
    obs, _ = envs.reset(seed=1)
    assert obs.shape == (2, 4)
    rewards = np.zeros(2)
    for _ in range(3):
        obs, reward, _, truncated, infos = envs.step(np.zeros((2, 1), dtype=np.float32))
        rewards += reward
    assert truncated.all()
    for info, total in zip(infos, rewards, strict=True):
        assert info["episode"]["l"] == 3
        assert info["episode"]["r"] == pytest.approx(total)
        assert info["final_obs"].shape == (4,)
        assert "Episode_Reward/alive" in info["log"]
    assert len(films) == 1


def _cartpole():
    from lift_lab_tasks.utils import parse_env_cfg

    cfg = parse_env_cfg("lift_lab_tasks:Cartpole", device="cpu", num_envs=4)
    cfg.seed, cfg.sim.num_threads = 0, 1
    return cfg


@pytest.mark.parametrize("make", [gym.make, gym.make_vec])
def test_make_takes_number_of_environments_and_device(arm, opened, make):
    env = opened(make(arm, num_envs=3, device="cpu"))
    rows = env.num_envs if make is gym.make_vec else env.unwrapped.num_envs
    assert rows == 3
    env.reset()
    obs, *_ = env.step(torch.zeros(3, 2))
    assert len(obs["policy"]) == 3


def test_make_changes_a_copy_of_a_given_configuration(arm, opened, make_cfg):
    cfg = make_cfg()
    before = cfg.scene.num_envs
    env = opened(gym.make(arm, cfg=cfg, num_envs=before + 1))
    assert (env.unwrapped.num_envs, cfg.scene.num_envs) == (before + 1, before)
    same = opened(gym.make(arm, cfg=cfg))
    assert same.unwrapped.cfg is cfg


@pytest.mark.parametrize("make", [gym.make, gym.make_vec])
def test_an_unknown_argument_of_make_is_named(arm, make):
    with pytest.raises(ConfigError, match=r"unknown argument 'num_env' of an environment: did you mean 'num_envs'"):
        make(arm, num_env=3)


def test_arguments_that_a_task_is_registered_with_are_taken(arm, opened):
    gym.registry["Arm"].kwargs["robot_name"] = "arm"
    opened(gym.make(arm))
    opened(gym.make(arm, robot_name="leg"))
