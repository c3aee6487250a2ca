"""Ranges of the numbers in the agent configurations of Stable-Baselines3 and skrl, which are dictionaries."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from lift_lab.utils.errors import ConfigError, LiftLabError
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


SB3_NEEDED = "policy n_timesteps n_steps n_epochs gamma gae_lambda learning_rate clip_range ent_coef vf_coef"
SKRL_NEEDED = (
    "models models.policy models.value memory agent trainer agent.experiment agent.rollouts agent.learning_epochs "
    "agent.mini_batches agent.discount_factor agent.gae_lambda agent.learning_rate agent.ratio_clip trainer.timesteps"
)
"""Entries that may be missing, which leaves the library's default, but not null."""


def check_library_cfg(cfg: dict[str, Any], ranges: Ranges, needed: str) -> None:
    """Check the numbers of an agent's configuration.

    Args:
        cfg: the configuration.
        ranges: ranges by the path of an entry; a key may name several, separated by spaces.
        needed: entries that may be missing, which leaves the library's default, but not None; separated by spaces.

    Raises:
        ConfigError: a number is NaN or outside of its range, or an entry that is needed is None; names it.
    """
    for name in needed.split():
        *owners, last = name.split(".")
        owner: Any = cfg
        for key in owners:
            owner = owner.get(key) if isinstance(owner, dict) else None
        if isinstance(owner, dict) and last in owner and owner[last] is None:
            raise ConfigError(f"agent.{name} is null; it is needed")
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


def check_skrl_mini_batches(cfg: dict[str, Any], num_envs: int) -> None:
    """Check that no mini-batch of skrl's agent is empty: the mean loss of an empty one is NaN.

    Args:
        cfg: configuration of skrl's runner.
        num_envs: number of environments.

    Raises:
        ConfigError: a rollout has fewer samples than there are mini-batches.
    """
    rollouts, count = cfg["agent"].get("rollouts"), cfg["agent"].get("mini_batches")
    if rollouts and count and rollouts * num_envs < count:
        raise ConfigError(
            f"agent.agent.mini_batches is {count}: a rollout of {num_envs} environments and {rollouts} steps has "
            f"only {rollouts * num_envs} samples"
        )


@contextlib.contextmanager
def refusals_of(library: str) -> Iterator[None]:
    """Turn a library's errors about its settings into one line while it builds an agent.

    Args:
        library: name of the library, for the message.

    Raises:
        ConfigError: the library refused a setting; holds its message.
    """
    try:
        yield
    except (TypeError, ValueError, NameError) as error:
        if isinstance(error, LiftLabError):
            raise
        raise ConfigError(f"{library} refuses a setting below agent: {error}") from error
