"""PPO settings of the Franka reach tasks (Isaac Lab's numbers), a folder of runs for each kind of action."""

from __future__ import annotations

from lift_lab.utils import configclass
from lift_lab_rl.rsl_rl import RslRlOnPolicyRunnerCfg, RslRlPpoActorCriticCfg, RslRlPpoAlgorithmCfg


@configclass
class FrankaReachPPORunnerCfg(RslRlOnPolicyRunnerCfg):
    """Gaussian MLP 64-64, 24-step rollouts."""

    num_steps_per_env = 24
    max_iterations = 1000
    save_interval = 50
    experiment_name = "franka_reach"
    policy = RslRlPpoActorCriticCfg(
        init_noise_std=1.0,
        actor_obs_normalization=False,
        critic_obs_normalization=False,
        actor_hidden_dims=[64, 64],
        critic_hidden_dims=[64, 64],
        activation="elu",
    )
    algorithm = RslRlPpoAlgorithmCfg(
        value_loss_coef=1.0,
        use_clipped_value_loss=True,
        clip_param=0.2,
        entropy_coef=0.001,
        num_learning_epochs=8,
        num_mini_batches=4,
        learning_rate=1.0e-3,
        schedule="adaptive",
        gamma=0.99,
        lam=0.95,
        desired_kl=0.01,
        max_grad_norm=1.0,
    )


@configclass
class FrankaReachIKRelPPORunnerCfg(FrankaReachPPORunnerCfg):
    """The same for changes of the hand's pose."""

    experiment_name = "franka_reach_ik_rel"


@configclass
class FrankaReachIKAbsPPORunnerCfg(FrankaReachPPORunnerCfg):
    """The same for poses of the hand."""

    experiment_name = "franka_reach_ik_abs"
