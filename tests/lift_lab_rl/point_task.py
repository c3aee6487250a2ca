"""A small task and agent that the tests of training share: seconds to train, and no physics."""

import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

from lift_lab.utils import configclass
from lift_lab_rl.rsl_rl import (
    LiftLabRunner,
    RslRlOnPolicyRunnerCfg,
    RslRlPpoActorCriticCfg,
    RslRlPpoAlgorithmCfg,
    to_rsl_rl,
)


@configclass
class AgentCfg(RslRlOnPolicyRunnerCfg):
    num_steps_per_env = 8
    max_iterations = 4
    save_interval = 2
    experiment_name = "test"
    policy = RslRlPpoActorCriticCfg(
        init_noise_std=1.0,
        noise_std_type="log",
        actor_obs_normalization=True,
        critic_obs_normalization=True,
        actor_hidden_dims=[16, 8],
        critic_hidden_dims=[16, 8],
        activation="elu",
    )
    algorithm = RslRlPpoAlgorithmCfg(
        value_loss_coef=1.0,
        use_clipped_value_loss=True,
        clip_param=0.2,
        entropy_coef=0.006,
        num_learning_epochs=2,
        num_mini_batches=2,
        learning_rate=1e-3,
        schedule="adaptive",
        gamma=0.99,
        lam=0.95,
        desired_kl=0.01,
        max_grad_norm=1.0,
    )


def with_algorithm(cfg, **settings):
    """The agent's configuration with other settings of its algorithm."""
    for name, value in settings.items():
        setattr(cfg.algorithm, name, value)
    return cfg


class PointEnv(VecEnv):
    """Points on a line that are paid for being near zero; episodes of 20 steps.

    Attributes:
        position: of each point, shape (num_envs, 1), in m.
        steps: steps taken.
    """

    num_actions, max_episode_length, device, step_dt = 1, 20, "cpu", 0.02

    def __init__(self, num_envs=32, on_step=None):
        """Start at random places.

        Args:
            num_envs: points.
            on_step: called with the number of the step before it is taken.
        """
        self.num_envs, self.cfg = num_envs, {}
        self.position = torch.rand(num_envs, 1) * 2.0 - 1.0
        self.episode_length_buf = torch.zeros(num_envs, dtype=torch.long)
        self.on_step, self.steps = on_step, 0

    @property
    def unwrapped(self):
        return self

    def get_observations(self):
        return TensorDict({"policy": torch.cat([self.position, self.position**2], 1)}, batch_size=[self.num_envs])

    def step(self, actions):
        self.steps += 1
        if self.on_step is not None:
            self.on_step(self.steps)
        self.position = self.position + 0.1 * actions
        self.episode_length_buf = self.episode_length_buf + 1
        reward = -self.position[:, 0].abs()
        done = self.episode_length_buf >= self.max_episode_length
        log = {}
        if done.any():
            log = {"Metrics/success": (self.position[done].abs() < 0.2).float().mean()}
        self.position = torch.where(done[:, None], torch.rand(self.num_envs, 1) * 2.0 - 1.0, self.position)
        self.episode_length_buf = torch.where(done, 0, self.episode_length_buf)
        return self.get_observations(), reward, done.long(), {"time_outs": done, "log": log}


def train(folder, iterations=4, threads=1, on_step=None, cfg=None):
    """Train points in the folder; the runner, and whether it finished."""
    torch.manual_seed(5)
    cfg = cfg if cfg is not None else AgentCfg()
    cfg.num_threads = threads
    runner = LiftLabRunner(PointEnv(on_step=on_step), to_rsl_rl(cfg), log_dir=folder)
    if runner.alg.micro_batches is not None:
        runner.alg.micro_batches.rows = 32
    finished = runner.learn(iterations, init_at_random_ep_len=True)
    return runner, finished
