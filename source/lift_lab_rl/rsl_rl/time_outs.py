"""Bootstrapping of episodes that a time limit ends, from the last observation of the episode.

An episode that a time limit ends would have gone on. Its return is therefore the rewards up to the limit and the value
of the state that the last action led to. rsl_rl takes the value of the state before that action instead, because an
environment that resets itself returns the first observation of the next episode. Environments here can give both
(:attr:`~lift_lab.envs.ManagerBasedRLEnv.wants_final_obs`).
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import torch
from tensordict import TensorDict

from lift_lab.utils.errors import ConfigError

PREVIOUS_OBS, FINAL_OBS = "previous_obs", "final_obs"
"""Forms of ``agent.algorithm.time_out_bootstrap``."""


def check_final_obs(env: Any) -> None:
    """Check that the value of last observations can be used with an environment.

    Args:
        env: wrapped environment.

    Raises:
        ConfigError: it does not give last observations, or it has a finite horizon, at which nothing is bootstrapped.
    """
    setting = f"agent.algorithm.time_out_bootstrap={FINAL_OBS}"
    if not hasattr(getattr(env, "unwrapped", None), "wants_final_obs"):
        raise ConfigError(
            f"{setting} needs a manager-based environment: {type(env).__name__} does not give the last observations of "
            f"episodes; use {PREVIOUS_OBS}"
        )
    if getattr(env.cfg, "is_finite_horizon", False):
        raise ConfigError(
            f"{setting} has no effect on a task with a finite horizon (env.is_finite_horizon): nothing is bootstrapped "
            f"there; use {PREVIOUS_OBS}"
        )


@contextlib.contextmanager
def providing_final_obs(env: Any, wanted: bool) -> Iterator[None]:
    """Let the environment put last observations into ``extras["final_obs"]`` for as long as the block runs.

    Args:
        env: wrapped environment.
        wanted: whether they are wanted; otherwise nothing is done.
    """
    if not wanted:
        yield
        return
    inner = env.unwrapped
    before, inner.wants_final_obs = inner.wants_final_obs, True
    try:
        yield
    finally:
        inner.wants_final_obs = before


def final_values(critic: Any, time_outs: torch.Tensor, final_obs: Any) -> torch.Tensor:
    """Return the critic's values of the last observations of the episodes that a time limit ended.

    On the CPU only those episodes are computed. On another device all rows are: choosing them would make the host wait.

    Args:
        critic: value network of rsl_rl. A recurrent one keeps its memory.
        time_outs: 1 where a time limit ended the episode, else 0, shape (num_envs, 1), on the critic's device.
        final_obs: last observations by group, of all environments; None in a step in which no episode ended.

    Returns:
        Values, shape (num_envs, 1); 0 where no time limit ended an episode.
    """
    values = torch.zeros_like(time_outs)
    if final_obs is None:
        return values
    groups = (*critic.obs_groups, *getattr(critic, "obs_groups_2d", ()))
    chosen = {name: final_obs[name].to(values.device) for name in groups}
    with torch.no_grad():
        if critic.is_recurrent or values.device.type != "cpu":
            memory = critic.get_hidden_state()
            found = critic(TensorDict(chosen, batch_size=[len(values)]))
            critic.reset(hidden_state=memory)
            return torch.where(time_outs > 0, found, values)
        rows = time_outs[:, 0].nonzero()[:, 0]
        if len(rows):
            values[rows] = critic(TensorDict({name: obs[rows] for name, obs in chosen.items()}, batch_size=[len(rows)]))
    return values
