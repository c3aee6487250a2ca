"""rsl_rl's own runners train on our wrapper, as in a script of a user's."""

import gymnasium as gym
import pytest
import torch
from rsl_rl.runners import DistillationRunner, OnPolicyRunner

import lift_lab_tasks  # noqa: F401
from lift_lab_rl.rsl_rl import LiftLabPPO, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg

MLP = {"class_name": "MLPModel", "hidden_dims": [8], "activation": "elu"}
GAUSSIAN = {"class_name": "GaussianDistribution", "init_std": 0.5}


@pytest.fixture
def env():
    cfg = parse_env_cfg("Cartpole", device="cpu", num_envs=8)
    cfg.seed, cfg.episode_length_s = 3, 0.2
    env = RslRlVecEnvWrapper(gym.make("Cartpole", cfg=cfg))
    yield env
    env.close()


def weights(runner):
    return torch.cat([p.detach().flatten() for p in runner.get_inference_policy().parameters()])


@pytest.mark.parametrize("name", ["LiftLabPPO", "PPO"])
def test_the_on_policy_runner_trains_saves_and_loads(env, tmp_path, name):
    agent_cfg = load_cfg_from_registry("Cartpole", "rsl_rl_cfg_entry_point")
    agent_cfg.algorithm.class_name = name
    cfg = to_rsl_rl(agent_cfg)
    runner = OnPolicyRunner(env, cfg, str(tmp_path), "cpu")
    before = weights(runner)
    runner.learn(2, init_at_random_ep_len=True)
    assert isinstance(runner.alg, LiftLabPPO) is (name == "LiftLabPPO")
    assert not torch.equal(weights(runner), before)
    again = OnPolicyRunner(env, to_rsl_rl(agent_cfg), None, "cpu")
    again.load(str(tmp_path / "model_1.pt"))
    assert torch.equal(weights(again), weights(runner))


def test_the_distillation_runner_teaches_a_student(env, tmp_path):
    agent_cfg = load_cfg_from_registry("Cartpole", "rsl_rl_cfg_entry_point")
    agent_cfg.policy.actor_hidden_dims, agent_cfg.policy.actor_obs_normalization = [8], False
    teacher = OnPolicyRunner(env, to_rsl_rl(agent_cfg), str(tmp_path), "cpu")
    teacher.learn(1)
    algorithm = {"class_name": "Distillation", "num_learning_epochs": 2, "gradient_length": 2, "learning_rate": 1e-2}
    cfg = {
        "num_steps_per_env": 4,
        "save_interval": 10,
        "obs_groups": {"student": ["policy"], "teacher": ["policy"]},
        "student": MLP | {"distribution_cfg": GAUSSIAN},
        "teacher": MLP | {"distribution_cfg": GAUSSIAN},
        "algorithm": algorithm,
    }
    runner = DistillationRunner(env, cfg, None, "cpu")
    runner.load(str(tmp_path / "model_0.pt"))
    before, obs = weights(runner), env.get_observations()

    def distance():
        with torch.no_grad():
            return (runner.alg.student(obs) - runner.alg.teacher(obs)).square().mean().item()

    far = distance()
    runner.learn(10)
    assert not torch.equal(weights(runner), before)
    assert distance() < 0.5 * far
