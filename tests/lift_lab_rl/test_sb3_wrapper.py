"""Stable-Baselines3 sees an environment as its own kind, trains in it, and gets back what it saved."""

import gymnasium as gym
import numpy as np
import pytest
import torch

pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is not installed (the extra 'sb3')")

from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl.files import save_torch
from lift_lab_rl.sb3 import Sb3VecEnvWrapper, process_sb3_cfg
from lift_lab_rl.sb3_runs import build, load_parameters, load_statistics, save, save_statistics, statistics_path
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg


@pytest.fixture
def make():
    """Makes a wrapped task; closed at the end."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    made = []

    def call(num_envs, task="Cartpole", **settings):
        cfg = parse_env_cfg(task, device="cpu", num_envs=num_envs)
        cfg.seed, cfg.sim.num_threads = 3, 1
        for name, value in settings.items():
            setattr(cfg, name, value)
        made.append(Sb3VecEnvWrapper(gym.make(task, cfg=cfg)))
        return made[-1]

    yield call
    for env in made:
        env.close()
    torch.set_num_threads(threads)


def mean_reward(agent, vec_env, inner, steps=300):
    """Reward a second over whole episodes of the policy without noise."""
    obs, total = vec_env.reset(), 0.0
    for _ in range(steps):
        obs, rewards, _, _ = vec_env.step(agent.predict(obs, deterministic=True)[0])
        total += float(rewards.mean())
    return total / (steps * inner.unwrapped.step_dt)


def test_spaces_are_those_of_one_environment_with_bounded_actions(make):
    env = make(3)
    assert env.num_envs == 3
    assert env.observation_space.shape == (4,)
    assert env.action_space == gym.spaces.Box(-100.0, 100.0, (1,))
    obs = env.reset()
    assert obs.shape == (3, 4)
    assert obs.dtype == np.float32


def test_an_episode_that_time_ended_hands_out_its_last_observation(make):
    env = make(2, episode_length_s=4 / 60)
    env.reset()
    twin = make(2)  # the same random numbers, but its episodes go on
    twin.reset()
    actions = np.zeros((2, 1), dtype=np.float32)
    returns = np.zeros(2)
    for step in range(4):
        obs, rewards, dones, infos = env.step(actions)
        going_on, *_ = twin.step(actions)
        returns += rewards
        assert dones.all() == (step == 3)
    for idx, info in enumerate(infos):
        np.testing.assert_array_equal(info["terminal_observation"], going_on[idx])
        assert not np.array_equal(info["terminal_observation"], obs[idx])
        assert info["TimeLimit.truncated"] is True
        assert info["episode"]["l"] == 4
        assert info["episode"]["r"] == pytest.approx(returns[idx])
    _, _, _, infos = env.step(actions)
    assert infos == [{}, {}]


def test_an_episode_that_a_termination_or_a_finite_horizon_ended_is_not_bootstrapped(make):
    finite = make(1, episode_length_s=1 / 60, is_finite_horizon=True)
    finite.reset()
    _, _, dones, infos = finite.step(np.zeros((1, 1)))
    assert dones.all()
    assert infos[0]["TimeLimit.truncated"] is False
    failing = make(1)
    failing.reset()
    failing.unwrapped.termination_manager.get_term_cfg("cart_out_of_bounds").params["bounds"] = (5.0, 6.0)
    _, _, dones, infos = failing.step(np.zeros((1, 1)))
    assert dones.all()
    assert infos[0]["TimeLimit.truncated"] is False


class Paying(Sb3VecEnvWrapper):
    """Pays more from the second episode on, which begins after 4 steps."""

    bonus = 0.0

    def step_wait(self):
        obs, rewards, dones, infos = super().step_wait()
        return obs, rewards + self.bonus * (self.unwrapped.common_step_counter > 4), dones, infos


def learnt(make, bonus=0.0):
    """Rollout and agent of the shipped settings, whose networks do not change."""
    env = make(2, episode_length_s=4 / 60)
    env.__class__, env.bonus = Paying, bonus
    cfg = load_cfg_from_registry("Cartpole", "sb3_cfg_entry_point") | {"n_steps": 12, "learning_rate": 0.0}
    agent, _, _ = build(env, cfg)
    agent.learn(12 * env.num_envs)
    return agent.rollout_buffer, agent


def test_a_return_at_a_time_limit_is_the_reward_and_the_value_of_the_last_observation(make):
    rollout, agent = learnt(make)
    actions, returns = rollout.actions.reshape(2, 12, 1), rollout.returns.reshape(2, 12)
    twin = make(2)  # from the same state, but its episodes go on
    twin.reset()
    state = torch.as_tensor(rollout.observations.reshape(2, 12, 4)[:, 0])  # positions and velocities
    twin.unwrapped.scene["robot"].write_joint_state_to_sim(state[:, :2], state[:, 2:])
    for step in range(4):
        obs, rewards, *_ = twin.step(actions[:, step].clip(-100.0, 100.0))
    with torch.no_grad():
        value = agent.policy.predict_values(torch.as_tensor(obs)).numpy()[:, 0]
    np.testing.assert_allclose(returns[:, 3], rewards + agent.gamma * value, atol=1e-6, rtol=1e-5)
    assert np.abs(value).min() > 1e-4


def test_the_next_episodes_pay_changes_no_return_of_an_episode_that_a_time_limit_ended(make):
    plain, paid = (learnt(make, bonus)[0].returns.reshape(2, 12) for bonus in (0.0, 100.0))
    np.testing.assert_array_equal(plain[:, :4], paid[:, :4])
    assert (paid[:, 4:] > plain[:, 4:] + 50.0).all()


def test_all_infos_hold_the_log_on_request(make):
    env = make(1, episode_length_s=1 / 60)
    full = Sb3VecEnvWrapper(env.env, fast_variant=False)
    full.reset()
    _, _, _, infos = full.step(np.zeros((1, 1)))
    assert "Episode_Reward/alive" in infos[0]["episode"]


def test_attributes_and_methods_are_answered_once_for_each_environment(make):
    env = make(3)
    env.reset()
    env.step(np.zeros((3, 1)))
    assert env.get_attr("episode_length_buf", [0, 2]) == [1, 1]
    assert env.get_attr("step_dt") == [pytest.approx(1 / 60)] * 3
    assert not env.has_attr("nothing")
    assert len(env.env_method("get_wrapper_attr", "num_envs")) == 3
    assert env.env_is_wrapped(gym.wrappers.OrderEnforcing) == [True] * 3
    assert env.get_episode_lengths() == [1, 1, 1]
    assert env.seed(5) == [5, 5, 5]
    with pytest.raises(ConfigError, match="leave indices out"):
        env.set_attr("x", 1, indices=[0])


def test_a_configuration_becomes_arguments():
    plain = {
        "n_steps": 8,
        "n_minibatches": 4,
        "learning_rate": "lin_1e-3",
        "policy_kwargs": {"activation_fn": "nn.ELU"},
    }
    found = process_sb3_cfg(plain, num_envs=6)
    assert found["batch_size"] == 12
    assert found["learning_rate"](0.25) == pytest.approx(2.5e-4)
    assert found["policy_kwargs"]["activation_fn"] is torch.nn.ELU
    assert plain["n_minibatches"] == 4


@pytest.mark.parametrize(
    ("cfg", "message"),
    [
        ({"n_steps": 3, "n_minibatches": 4}, "3 samples cannot be cut into 4"),
        ({"learning_rate": "fast"}, "learning_rate: expected a number"),
        ({"policy_kwargs": {"activation_fn": "nn.ELLU"}}, "did you mean 'ELU'"),
    ],
)
def test_a_wrong_configuration_is_answered_with_its_key(cfg, message):
    with pytest.raises(ConfigError, match=message):
        process_sb3_cfg(cfg, num_envs=1)


def test_an_argument_that_ppo_does_not_know_is_named(make):
    cfg = load_cfg_from_registry("Cartpole", "sb3_cfg_entry_point") | {"n_epoch": 3}
    with pytest.raises(ConfigError, match="no argument 'n_epoch'; did you mean 'n_epochs'"):
        build(make(1), cfg)


def test_the_cart_pole_is_learned_and_comes_back_from_its_file(make, tmp_path):
    env = make(64)
    cfg = load_cfg_from_registry("Cartpole", "sb3_cfg_entry_point")
    agent, vec_env, _ = build(env, cfg)
    before = mean_reward(agent, vec_env, env)
    agent.learn(60 * cfg["n_steps"] * env.num_envs)
    save(agent, vec_env, tmp_path / "model.zip")
    env.unwrapped.seed(8)
    after = mean_reward(agent, vec_env, env)
    assert before < -1.0  # the pole hangs
    assert after > 0.5  # at most 1: alive, upright and still

    loaded, again, _ = build(env, cfg, tmp_path / "model.zip", training=False)
    env.unwrapped.seed(8)
    assert mean_reward(loaded, again, env) == after


def test_statistics_of_observations_are_saved_beside_the_model(make, tmp_path):
    env = make(2, task="Lift-Cube-Franka")
    cfg = load_cfg_from_registry("Lift-Cube-Franka", "sb3_cfg_entry_point")
    agent, vec_env, _ = build(env, cfg)
    agent.learn(2 * cfg["n_steps"] * env.num_envs)
    path = tmp_path / "model_96_steps.zip"
    save(agent, vec_env, path)
    assert statistics_path(path).name == "model_vecnormalize_96_steps.pt"
    loaded, again, _ = build(env, cfg | {"n_minibatches": 7}, path, training=False)  # the parts are for learning
    np.testing.assert_array_equal(again.obs_rms.mean, vec_env.obs_rms.mean)
    obs = np.linspace(-1, 1, 72).reshape(2, 36)
    vec_env.training = False
    for raw in (obs, 5 * obs):
        first = agent.predict(vec_env.normalize_obs(raw), deterministic=True)[0]
        second = loaded.predict(again.normalize_obs(raw), deterministic=True)[0]
        np.testing.assert_array_equal(first, second)
    statistics_path(path).unlink()
    with pytest.raises(FileError, match=r"model_96_steps.zip' lacks .* '.*model_vecnormalize_96_steps.pt'"):
        build(env, cfg, path, training=False)
    build(env, cfg | {"normalize_input": False}, path, training=False)

    older = statistics_path(path).with_suffix(".pkl")  # as Stable-Baselines3 writes them
    vec_env.save(str(older))
    with pytest.raises(FileError, match=r"96_steps.pkl' holds pickled Python objects.*add --trust"):
        build(env, cfg, path, training=False)
    _, trusted, _ = build(env, cfg, path, training=False, trust=True)
    np.testing.assert_array_equal(trusted.obs_rms.var, vec_env.obs_rms.var)


def test_statistics_come_back_bit_by_bit_also_of_groups_that_are_dicts(make, tmp_path):
    spaces = gym.spaces.Dict({name: gym.spaces.Box(-1, 1, (size,)) for name, size in (("a", 2), ("b", 3))})
    env = DummyVecEnv([lambda: Dictionary(spaces)])
    first, second, other = VecNormalize(env), VecNormalize(env), VecNormalize(make(1))
    first.reset()
    for _ in range(5):
        first.step(np.zeros((1, 1), dtype=np.float32))
    path = tmp_path / "model_vecnormalize.pt"
    save_statistics(first, path)
    load_statistics(second, path)
    for name in ("a", "b"):
        for part in ("mean", "var", "count"):
            np.testing.assert_array_equal(getattr(second.obs_rms[name], part), getattr(first.obs_rms[name], part))
    np.testing.assert_array_equal(second.ret_rms.var, first.ret_rms.var)
    with pytest.raises(ConfigError, match="of other observations"):
        load_statistics(other, path)
    save_torch(path, {"observations": {}})
    with pytest.raises(ConfigError, match="holds no statistics"):
        load_statistics(second, path)


class Dictionary(gym.Env):
    """Random observations in a dict."""

    action_space = gym.spaces.Box(-1, 1, (1,))

    def __init__(self, spaces):
        self.observation_space = spaces
        spaces.seed(1)

    def reset(self, *, seed=None, options=None):
        return self.observation_space.sample(), {}

    def step(self, action):
        return self.observation_space.sample(), 1.0, False, False, {}


def test_an_agent_that_a_file_does_not_fit_stays_as_it_is(make, tmp_path):
    env, cfg = make(2), load_cfg_from_registry("Cartpole", "sb3_cfg_entry_point")
    agent, vec_env, _ = build(env, cfg)
    save(agent, vec_env, tmp_path / "model.zip")
    other, _, _ = build(env, cfg | {"policy_kwargs": {"activation_fn": "nn.ELU", "net_arch": [16]}})
    before = {name: value.clone() for name, value in other.policy.state_dict().items()}
    with pytest.raises(ConfigError, match=r"model\.zip' does not fit this agent: Error") as caught:
        load_parameters(other, tmp_path / "model.zip")
    assert "\n" not in str(caught.value)
    assert all(torch.equal(value, before[name]) for name, value in other.policy.state_dict().items())
    load_parameters(agent, tmp_path / "model.zip")
