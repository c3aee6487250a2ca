"""PPO settings of the Franka lift tasks (the paper's section 3.3; see docs/learning.md for what was measured)."""

from __future__ import annotations

from lift_lab.utils import configclass
from lift_lab_rl.rsl_rl import RslRlOnPolicyRunnerCfg, RslRlPpoActorCriticCfg, RslRlPpoAlgorithmCfg


@configclass
class LiftCubePPORunnerCfg(RslRlOnPolicyRunnerCfg):
    """Gaussian MLP 256-128-64, 24-step rollouts, adaptive learning rate."""

    num_steps_per_env = 24
    max_iterations = 1000
    save_interval = 50
    average_share = 0.04
    experiment_name = "franka_lift"
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
        entropy_coef=0.003,
        entropy_coef_final=0.0,
        desired_kl_final=0.008,
        anneal_iterations=(600, 900),
        mean_reg_coef=0.003,
        advantage_clip=0.5,
        advantage_clip_start=750,
        num_learning_epochs=5,
        num_mini_batches=4,
        learning_rate=1.0e-3,
        schedule="adaptive",
        gamma=0.97,
        gamma_final=0.985,
        lam=0.95,
        desired_kl=0.02,
        max_grad_norm=1.0,
    )


@configclass
class LiftSoftCubePPORunnerCfg(LiftCubePPORunnerCfg):
    """For the soft cube: the same, a folder of runs of its own."""

    experiment_name = "franka_lift_soft"
