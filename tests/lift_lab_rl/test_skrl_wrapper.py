"""skrl sees an environment as Isaac Lab's, trains in it, and gets back what it saved."""

import copy

import gymnasium as gym
import pytest
import torch

pytest.importorskip("skrl", reason="skrl is not installed (the extra 'skrl')")

from skrl.utils.runner.torch import Runner

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError
from lift_lab_rl.skrl import SkrlVecEnvWrapper
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg


@pytest.fixture
def make():
    """Makes a wrapped task; closed at the end."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    made = []

    def call(num_envs, task="Cartpole", seed=3, **settings):
        cfg = parse_env_cfg(task, device="cpu", num_envs=num_envs)
        cfg.seed, cfg.sim.num_threads = seed, 1
        for name, value in settings.items():
            setattr(cfg, name, value)
        made.append(SkrlVecEnvWrapper(gym.make(task, cfg=cfg)))
        return made[-1]

    yield call
    for env in made:
        env.close()
    torch.set_num_threads(threads)


def agent_cfg(task="Cartpole", rollouts=1, folder=None):
    cfg = load_cfg_from_registry(task, "skrl_cfg_entry_point")
    cfg["trainer"]["timesteps"] = rollouts * cfg["agent"]["rollouts"]
    experiment = cfg["agent"]["experiment"]
    experiment["write_interval"] = experiment["checkpoint_interval"] = 0
    return cfg


def mean_reward(agent, env, steps=300):
    """Reward a second over whole episodes of the policy without noise."""
    agent.enable_training_mode(False, apply_to_models=True)
    obs, _ = env._env.reset(seed=8)
    obs, total = obs["policy"], 0.0
    with torch.inference_mode():
        for step in range(steps):
            _, outputs = agent.act(obs, None, timestep=step, timesteps=steps)
            obs, rewards, *_ = env.step(outputs["mean_actions"])
            total += float(rewards.mean())
    return total / (steps * env.unwrapped.step_dt)


def test_spaces_are_those_of_one_environment(make):
    env = make(3)
    assert env.num_envs == 3
    assert env.observation_space.shape == (4,)
    assert env.action_space.shape == (1,)
    assert env.state_space is None
    obs, _ = env.reset()
    assert obs.shape == (3, 4)
    obs, rewards, terminated, truncated, _ = env.step(torch.zeros(3, 1))
    assert obs.shape == (3, 4)
    assert rewards.shape == terminated.shape == truncated.shape == (3, 1)


def test_random_numbers_follow_the_environments_seed(make):
    first, _ = make(4, seed=3).reset()
    again, _ = make(4, seed=3).reset()
    other, _ = make(4, seed=4).reset()
    assert torch.equal(first, again)
    assert not torch.equal(first, other)


def test_an_agent_may_change_rewards_in_place(make):
    env = make(2)
    env.reset()
    _, rewards, *_ = env.step(torch.zeros(2, 1))
    kept = env.unwrapped.reward_buf.clone()
    rewards += 7.0
    assert torch.equal(env.unwrapped.reward_buf, kept)


def test_the_end_of_a_finite_horizon_is_a_termination(make):
    for finite in (False, True):
        env = make(2, episode_length_s=1 / 60, is_finite_horizon=finite)
        env.reset()
        _, _, terminated, truncated, _ = env.step(torch.zeros(2, 1))
        assert bool(terminated.all()) is finite
        assert bool(truncated.all()) is not finite


@pytest.mark.parametrize(("more", "message"), [({"ml_framework": "jax"}, "'torch'"), ({"wrapper": "gym"}, "'gym'")])
def test_other_frameworks_and_wrappers_are_refused(make, more, message):
    env = make(1)
    with pytest.raises(ConfigError, match=message):
        SkrlVecEnvWrapper(env._env, **more)


def test_the_cart_pole_is_learned_and_comes_back_from_its_file(make, tmp_path):
    env = make(128)
    cfg = agent_cfg(rollouts=60)
    runner = Runner(env, cfg)
    before = mean_reward(runner.agent, env)
    runner.run()
    runner.agent.save(str(tmp_path / "agent.pt"))
    after = mean_reward(runner.agent, env)
    assert before < -1.0  # the pole hangs
    assert after > 0.5  # at most 1: alive, upright and still

    loaded = Runner(env, copy.deepcopy(cfg)).agent
    loaded.load(str(tmp_path / "agent.pt"))
    assert mean_reward(loaded, env) == after


def test_the_lift_task_trains_with_normalised_observations(make, tmp_path):
    env = make(2, task="Lift-Cube-Franka")
    runner = Runner(env, agent_cfg("Lift-Cube-Franka", rollouts=2))
    weights = [parameter.clone() for parameter in runner.agent.policy.parameters()]
    runner.run()
    assert any(not torch.equal(a, b) for a, b in zip(weights, runner.agent.policy.parameters(), strict=True))
    runner.agent.save(str(tmp_path / "agent.pt"))
    saved = torch.load(tmp_path / "agent.pt", weights_only=False)
    assert saved["observation_preprocessor"]["running_mean"].shape == (36,)
