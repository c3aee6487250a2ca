"""PPO settings of the Franka cabinet task.

They differ from Isaac Lab's in normalised observations, a shorter rollout, a larger first learning rate, learned log
noise, and no clipping of the value loss. The drawer opens after a million samples (docs/learning.md).
"""

from __future__ import annotations

from lift_lab.utils import configclass
from lift_lab_rl.rsl_rl import RslRlOnPolicyRunnerCfg, RslRlPpoActorCriticCfg, RslRlPpoAlgorithmCfg


@configclass
class CabinetPPORunnerCfg(RslRlOnPolicyRunnerCfg):
    """Gaussian MLP 256-128-64, 24-step rollouts."""

    num_steps_per_env = 24
    max_iterations = 200
    save_interval = 50
    experiment_name = "franka_open_drawer"
    policy = RslRlPpoActorCriticCfg(
        init_noise_std=1.0,
        noise_std_type="log",
        actor_obs_normalization=True,
        critic_obs_normalization=True,
        actor_hidden_dims=[256, 128, 64],
        critic_hidden_dims=[256, 128, 64],
        activation="elu",
    )
    algorithm = RslRlPpoAlgorithmCfg(
        value_loss_coef=1.0,
        use_clipped_value_loss=False,
        clip_param=0.2,
        entropy_coef=1e-3,
        num_learning_epochs=5,
        num_mini_batches=4,
        learning_rate=1.0e-3,
        schedule="adaptive",
        gamma=0.99,
        lam=0.95,
        desired_kl=0.02,
        max_grad_norm=1.0,
    )
