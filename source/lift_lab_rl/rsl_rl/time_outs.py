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


class TimeOutBootstrap:
    """Adds the discounted value of what would have followed to the last reward of episodes that a time limit ended.

    Attributes:
        needs_final_obs: whether the environment has to give the last observations of the episodes that end.
    """

    def __init__(self, form: str, rewards: torch.Tensor):
        """Record nothing yet.

        Args:
            form: ``previous_obs``: the value of the observation before the last action, rsl_rl's form.
                ``final_obs``: the value of ``extras["final_obs"]``, after the last action.
            rewards: rewards of a rollout, shape (steps, num_envs, 1).
        """
        self.needs_final_obs = form == FINAL_OBS
        self._time_outs = torch.zeros_like(rewards)
        self._final_values = torch.zeros_like(rewards)

    def record(self, step: int, extras: dict[str, Any], critic: Any) -> None:
        """Record which episodes a time limit ended in a step; call before the critic's memory is reset.

        Args:
            step: number of the step in the rollout.
            extras: the environment's, with ``time_outs`` where there are some.
            critic: value network.
        """
        if "time_outs" not in extras:
            self._time_outs[step].zero_()
        else:
            self._time_outs[step].copy_(extras["time_outs"].view(-1, 1))
        if self.needs_final_obs:
            self._final_values[step].copy_(final_values(critic, self._time_outs[step], extras.get("final_obs")))

    def add_to(self, rewards: torch.Tensor, values: torch.Tensor, gamma: float) -> None:
        """Add the values to the rewards of a rollout, in place.

        Args:
            rewards: shape (steps, num_envs, 1).
            values: values of the observations before each action, in the same shape.
            gamma: discount factor.
        """
        rewards.addcmul_(self._final_values if self.needs_final_obs else values, self._time_outs, value=gamma)


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

    Raises:
        ConfigError: an episode ended without its last observations (looked for on the CPU only).
    """
    values = torch.zeros_like(time_outs)
    if final_obs is None:
        if values.device.type == "cpu" and bool(time_outs.any()):
            raise ConfigError(
                f"agent.algorithm.time_out_bootstrap={FINAL_OBS} needs the last observations of episodes: "
                f"set env.unwrapped.wants_final_obs = True before the training, or use {PREVIOUS_OBS}"
            )
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
