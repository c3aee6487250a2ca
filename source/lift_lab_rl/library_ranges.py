"""Ranges of the numbers in the agent configurations of Stable-Baselines3 and skrl, which are dictionaries."""

from __future__ import annotations

from typing import Any

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.ranges import (
    COUNT,
    COUNT_OR_ZERO,
    FINITE,
    FRACTION,
    NOT_NEGATIVE,
    NOT_NEGATIVE_OR_INF,
    POSITIVE,
    POSITIVE_OR_INF,
    SEED,
    Range,
    Ranges,
    first_problem,
)

SB3_RANGES: Ranges = {
    "seed": SEED,
    "n_timesteps n_steps n_epochs n_minibatches batch_size": COUNT,
    "gamma gae_lambda": FRACTION,
    "learning_rate clip_range clip_range_vf target_kl": POSITIVE,
    "ent_coef vf_coef": NOT_NEGATIVE,
    "max_grad_norm clip_obs": POSITIVE_OR_INF,
    "policy_kwargs.net_arch": COUNT,
    "policy_kwargs.log_std_init": FINITE,
}
"""By the path of an entry; a key may name several, separated by spaces."""

SKRL_RANGES: Ranges = {
    "seed": SEED,
    "agent.rollouts agent.learning_epochs agent.mini_batches trainer.timesteps": COUNT,
    "agent.discount_factor agent.gae_lambda agent.lambda": FRACTION,
    "agent.learning_rate agent.ratio_clip": POSITIVE,
    "agent.entropy_loss_scale agent.value_loss_scale agent.kl_threshold agent.value_clip": NOT_NEGATIVE,
    "agent.grad_norm_clip": NOT_NEGATIVE_OR_INF,
    "agent.random_timesteps agent.learning_starts": COUNT_OR_ZERO,
    "agent.experiment.write_interval agent.experiment.checkpoint_interval": COUNT_OR_ZERO,
    "memory.memory_size": Range(1, whole=True, also=(-1,)),
    "models.policy.initial_log_std models.policy.min_log_std models.policy.max_log_std": FINITE,
}
"""By the path of an entry; a key may name several, separated by spaces."""


def check_library_cfg(cfg: dict[str, Any]) -> None:
    """Check the numbers of an agent's configuration.

    Args:
        cfg: configuration of skrl's runner, which has a ``trainer``, or of Stable-Baselines3's PPO.

    Raises:
        ConfigError: a number is NaN or outside of its range; names it.
    """
    ranges = SKRL_RANGES if "trainer" in cfg else SB3_RANGES
    for names, known in ranges.items():
        for name in names.split():
            value: Any = cfg
            for key in name.split("."):
                value = value.get(key) if isinstance(value, dict) else None
            if isinstance(value, (str, bool)):  # a schedule by its name
                continue
            problem = known.problem(f"agent.{name}", value)
            if problem is not None:
                raise ConfigError(problem)
    problem = first_problem(cfg, "agent")
    if problem is not None:
        raise ConfigError(problem)
