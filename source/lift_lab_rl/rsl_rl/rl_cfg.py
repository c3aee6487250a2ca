"""Configuration of training with rsl_rl, in Isaac Lab 2.3's names.

Agent files written for Isaac Lab work unchanged. Fields that Isaac Lab does not have say so.
"""

from __future__ import annotations

import math
from typing import ClassVar, Literal

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import (
    COUNT,
    COUNT_OR_ZERO,
    FINITE,
    FRACTION,
    NOT_NEGATIVE,
    POSITIVE,
    POSITIVE_OR_INF,
    POSITIVE_SPAN_OR_INF,
    SEED,
    SIZES,
    Range,
    Ranges,
)

from .evaluation_cfg import RslRlEvaluationCfg
from .rnd_cfg import RslRlRndCfg
from .symmetry_cfg import RslRlSymmetryCfg


@configclass
class RslRlPpoActorCriticCfg(ConfigBase):
    """Networks of actor and critic: multi-layer perceptrons with a Gaussian policy."""

    class_name: str = "ActorCritic"
    """Kind of networks: ``ActorCritic``, or ``ActorCriticRecurrent``."""

    init_noise_std: float | list[float] = MISSING
    """Standard deviation of every action at the start, or one for each action (ours)."""

    init_action_mean: list[float] | None = None
    """Mean of each action at the start, plus the output of the random network; None for zero (ours). For actions that
    are poses or positions, of which zero is far from where the robot is."""

    noise_std_type: Literal["scalar", "log"] = "scalar"
    """Whether the standard deviation or its logarithm is learned."""

    noise_std_range: tuple[float, float] = (math.exp(-20.0), math.exp(2.0))
    """Bounds of the standard deviation (ours): its logarithm stays within [-20, 2]. rsl_rl never goes below 1e-6."""

    state_dependent_std: bool = False
    """Whether the network outputs the standard deviation too."""

    actor_obs_normalization: bool = MISSING
    """Whether the actor's observations are normalised by their running mean and deviation."""

    critic_obs_normalization: bool = MISSING
    """Whether the critic's observations are."""

    actor_hidden_dims: list[int] = MISSING
    """Widths of the actor's hidden layers."""

    critic_hidden_dims: list[int] = MISSING
    """Widths of the critic's hidden layers."""

    activation: str = MISSING
    """Activation between layers, e.g. ``elu``, ``relu``, ``tanh``."""

    _ranges: ClassVar[Ranges] = {
        "init_noise_std": POSITIVE,
        "init_action_mean": FINITE,
        "noise_std_range": POSITIVE_SPAN_OR_INF,
        "actor_hidden_dims critic_hidden_dims": SIZES,
    }


@configclass
class RslRlPpoActorCriticRecurrentCfg(RslRlPpoActorCriticCfg):
    """Networks with a recurrent layer in front."""

    class_name: str = "ActorCriticRecurrent"

    rnn_type: str = MISSING
    """``lstm`` or ``gru``."""

    rnn_hidden_dim: int = MISSING
    """Width of the recurrent layers."""

    rnn_num_layers: int = MISSING
    """Number of recurrent layers."""

    _ranges: ClassVar[Ranges] = {"rnn_hidden_dim rnn_num_layers": COUNT}


@configclass
class RslRlPpoAlgorithmCfg(ConfigBase):
    """Proximal policy optimization. docs/ppo.md says which settings are rsl_rl's and which are ours."""

    class_name: str = "LiftLabPPO"
    """``LiftLabPPO`` (ours: rsl_rl's with more parts), ``PPO`` (rsl_rl's), or ``"module:Class"`` of a sub-class of
    either. rsl_rl's has none of our parts: they must be off."""

    micro_batches: bool | None = None
    """Whether threads share the update in micro-batches (ours; the steps are rsl_rl's up to rounding).

    None: for networks that allow it. True: other networks are an error. False: the update is rsl_rl's.
    """

    num_learning_epochs: int = MISSING
    """Epochs: how often an update goes through the rollout."""

    num_mini_batches: int = MISSING
    """Minibatches in an epoch."""

    learning_rate: float = MISSING
    """Learning rate, at the start if the schedule adapts it."""

    schedule: Literal["adaptive", "fixed"] = MISSING
    """``adaptive`` keeps the policy's divergence in an update near ``desired_kl``; ``fixed``."""

    gamma: float = MISSING
    """Discount factor."""

    lam: float = MISSING
    """Lambda of generalized advantage estimation."""

    entropy_coef: float = MISSING
    """Weight of the entropy bonus."""

    desired_kl: float = MISSING
    """Divergence the adaptive schedule aims at."""

    entropy_coef_final: float | None = None
    """Entropy schedule: weight of the entropy bonus that training ends with (ours); None keeps :attr:`entropy_coef`."""

    desired_kl_final: float | None = None
    """Divergence that training ends with (ours); None keeps :attr:`desired_kl`."""

    gamma_final: float | None = None
    """Discount schedule: discount factor that training ends with (ours); None keeps :attr:`gamma`."""

    anneal_iterations: tuple[int, int] = (0, 0)
    """First and last iteration of the linear schedules of entropy bonus, divergence and discount factor (ours)."""

    anneal_at_success: float | None = None
    """Success rate at which the iterations of :attr:`anneal_iterations` and :attr:`advantage_clip_start` begin to count
    (ours); None counts from the start of the training.

    It is the smoothed success rate of the training's own episodes, with noise: a fifth of each iteration's, four fifths
    of what it was before. Without an episode that ended, an iteration does not count.
    """

    mean_reg_coef: float = 0.0
    """Mean-action regularisation: weight in the loss of the squared length of the mean action (ours; SAC of rlkit:
    ``policy_mean_reg_weight``); 0 for none.

    Where an action has no effect, as beyond a joint's limit, nothing else brings the policy back.
    """

    advantage_clip: float | None = None
    """Advantage clipping: largest size of an advantage in standard deviations of the rollout (ours); None for none.

    Clipped advantages are normalised again. Otherwise rare large losses, as of an object that slips away, outweigh
    what holding it more exactly would earn. Needs ``normalize_advantage_per_mini_batch=False``.
    """

    advantage_clip_start: int = 0
    """First iteration that clips advantages (ours); see also :attr:`anneal_at_success`."""

    time_out_bootstrap: Literal["previous_obs", "final_obs"] = "previous_obs"
    """Observation whose value stands for what follows an episode that a time limit ends (ours).

    ``previous_obs``: the one before the last action, as in rsl_rl; it is one step too early. ``final_obs``: the last
    one of the episode, after the last action and before the reset, which is exact. A task with a finite horizon is
    bootstrapped in neither form, so ``final_obs`` is refused there.
    """

    max_grad_norm: float = MISSING
    """Largest norm of the gradients of actor and of critic."""

    value_loss_coef: float = MISSING
    """Weight of the value loss."""

    use_clipped_value_loss: bool = MISSING
    """Whether a value may move by ``clip_param`` at most."""

    clip_param: float = MISSING
    """Clipping of the probability ratio."""

    normalize_advantage_per_mini_batch: bool = False
    """Whether advantages are normalised in each minibatch rather than in the rollout."""

    optimizer: Literal["adam", "adamw", "sgd", "rmsprop"] = "adam"
    """Optimiser."""

    rnd_cfg: RslRlRndCfg | None = None
    """Random network distillation; None for none."""

    symmetry_cfg: RslRlSymmetryCfg | None = None
    """Symmetry augmentation; None for none."""

    _ranges: ClassVar[Ranges] = {
        "num_learning_epochs num_mini_batches": COUNT,
        "learning_rate clip_param": POSITIVE,
        "gamma lam gamma_final anneal_at_success": FRACTION,
        "entropy_coef entropy_coef_final mean_reg_coef value_loss_coef": NOT_NEGATIVE,
        "desired_kl desired_kl_final advantage_clip": POSITIVE,
        "max_grad_norm": POSITIVE_OR_INF,
        "anneal_iterations": Range(0, whole=True, ascending=True),
        "advantage_clip_start": COUNT_OR_ZERO,
    }


@configclass
class RslRlBaseRunnerCfg(ConfigBase):
    """Settings of every runner."""

    seed: int = 42
    """Seed of the experiment."""

    device: str = "auto"
    """Device of the learner: ``cpu``, ``cuda:N``, or ``auto`` (ours) for the environment's."""

    num_threads: int | None = None
    """CPU threads that share the micro-batches of an update (ours); None for every CPU. Never changes a result."""

    num_steps_per_env: int = MISSING
    """Steps of each environment in a rollout."""

    max_iterations: int = MISSING
    """Iterations of the whole run. A resumed run does the rest of them."""

    empirical_normalization: bool | None = None
    """Isaac Lab's older switch for both observation normalisations; None leaves them as ``policy`` has them."""

    obs_groups: dict[str, list[str]] = {}
    """Observation groups of each observation set (``policy`` or ``actor``, ``critic``).

    If empty, the actor gets the group ``policy``. The critic gets the group ``critic`` where there is one, else
        ``policy``.
    """

    clip_actions: float | None = None
    """Actions are clipped to plus and minus this value; None for not at all."""

    check_for_nan: bool = True
    """Whether an infinite or NaN number in a rollout or an update ends the run (ours in this form: looked at once an
    iteration)."""

    save_interval: int = MISSING
    """Iterations between checkpoints."""

    keep_resume_states: int = 3
    """Checkpoints that keep the environments' state beside them, so that a run continues bit by bit (ours)."""

    average_share: float = 0.0
    """Exponential moving average (EMA) of the policy's weights: share of the training so far that it covers (ours).

    ``lift-lab play`` and ``lift-lab evaluate`` act with the average. 0: no average, they act with
    the last policy. Training itself never uses the average.
    """

    evaluation: RslRlEvaluationCfg | None = None
    """Evaluation during the training, which ends it once the task is solved (ours); None for none."""

    success_metric: str | None = None
    """Log key that ranks ``model_best.pt`` (ours). None takes ``Metrics/success_rate``; without that, the first key
    whose last part starts with "success"."""

    experiment_name: str = MISSING
    """Folder under ``logs/rsl_rl``."""

    run_name: str = ""
    """Appended to the run's folder name."""

    logger: Literal["tensorboard", "neptune", "wandb"] = "tensorboard"
    """Destination of curves. ``wandb`` needs its package; ``neptune`` is refused, its service has ended."""

    neptune_project: str = "lift_lab"
    """Kept for Isaac Lab's configurations."""

    wandb_project: str = "lift_lab"
    """Project name for Weights and Biases."""

    resume: bool = False
    """Whether to continue an earlier run."""

    load_run: str = ".*"
    """Regular expression of the run folder to load; the last match in alphabetical order is taken."""

    load_checkpoint: str = r"model_\d+\.pt"
    """Regular expression of the checkpoint to load; the last match in natural order is taken."""

    _ranges: ClassVar[Ranges] = {
        "seed": SEED,
        "num_threads num_steps_per_env max_iterations save_interval keep_resume_states": COUNT,
        "clip_actions": POSITIVE_OR_INF,
        "average_share": Range(0.0, 1.0, below=True),
    }


@configclass
class RslRlOnPolicyRunnerCfg(RslRlBaseRunnerCfg):
    """Runner of on-policy algorithms."""

    class_name: str = "OnPolicyRunner"
    """``OnPolicyRunner``: :class:`~lift_lab_rl.rsl_rl.runner.LiftLabRunner`."""

    policy: RslRlPpoActorCriticCfg = MISSING
    """Networks."""

    algorithm: RslRlPpoAlgorithmCfg = MISSING
    """Algorithm."""
