"""PPO settings of the Franka reach tasks, a folder of runs for each kind of action.

Isaac Lab's settings are for a hundred million samples. These need five to ten (docs/learning.md): normalised
observations, a shorter horizon, larger steps, no entropy bonus and a larger network.
"""

from __future__ import annotations

from lift_lab.utils import configclass
from lift_lab_rl.rsl_rl import RslRlOnPolicyRunnerCfg, RslRlPpoActorCriticCfg, RslRlPpoAlgorithmCfg


@configclass
class FrankaReachPPORunnerCfg(RslRlOnPolicyRunnerCfg):
    """Gaussian MLP 128-128-64, 24-step rollouts."""

    num_steps_per_env = 24
    max_iterations = 400
    save_interval = 50
    experiment_name = "franka_reach"
    policy = RslRlPpoActorCriticCfg(
        init_noise_std=1.0,
        noise_std_type="log",
        actor_obs_normalization=True,
        critic_obs_normalization=True,
        actor_hidden_dims=[128, 128, 64],
        critic_hidden_dims=[128, 128, 64],
        activation="elu",
    )
    algorithm = RslRlPpoAlgorithmCfg(
        value_loss_coef=1.0,
        use_clipped_value_loss=True,
        clip_param=0.2,
        entropy_coef=0.0,
        num_learning_epochs=8,
        num_mini_batches=4,
        learning_rate=1.0e-3,
        schedule="adaptive",
        gamma=0.97,
        lam=0.95,
        desired_kl=0.02,
        max_grad_norm=1.0,
    )


@configclass
class FrankaReachIKRelPPORunnerCfg(FrankaReachPPORunnerCfg):
    """The same for changes of the hand's pose; less noise at first, as one is half a metre."""

    experiment_name = "franka_reach_ik_rel"
    max_iterations = 800

    def __post_init__(self):
        super().__post_init__()
        self.policy.init_noise_std = 0.3


@configclass
class FrankaReachIKAbsPPORunnerCfg(FrankaReachPPORunnerCfg):
    """The same for poses of the hand; less noise at first, as one is a metre."""

    experiment_name = "franka_reach_ik_abs"
    max_iterations = 800

    def __post_init__(self):
        super().__post_init__()
        self.policy.init_noise_std = 0.2
