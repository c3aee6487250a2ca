"""Evaluation of a policy over whole episodes from the task's reset distribution, without bias.

Every environment runs the same number of whole episodes. They are counted in a fixed order: all first episodes by
environment, then all second ones. Counting the first episodes to *finish* would favour short ones.

A task defines its success. It is registered with ``"success": "module:function"`` or ``"success": {"func":
"module:function", "params": {...}}``. ``function(env, **params)`` returns the success of the state just reached, shape
(num_envs,). Otherwise the task has a termination term or a metrics term called ``success``. Success is read after every
step of an episode, the last included, before the environment is reset.
"""

from __future__ import annotations

import contextlib
import copy
import inspect
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import torch

from lift_lab.managers import ManagerTermBase, SceneEntityCfg, TerminationTermCfg
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.string import string_to_callable

from .episode_logs import FAILURES
from .intervals import wilson_interval
from .nonfinite import check_step

PROBE = "evaluation_probe"
"""Name of the termination term that watches for success and ends nothing."""


class SuccessProbe(ManagerTermBase):
    """A termination term that never ends an episode and notes when success was first seen."""

    def __init__(self, cfg: Any, env: Any):
        super().__init__(cfg, env)
        self.first_step = torch.zeros(env.num_envs, dtype=torch.long, device=env.device)
        """Step of the episode at which it first succeeded, 0 for not yet; shape (num_envs,)."""
        self._never = torch.zeros(env.num_envs, dtype=torch.bool, device=env.device)

    def __call__(self, env: Any, success: Any, success_params: dict[str, Any]) -> torch.Tensor:
        """Look at the state just reached.

        Raises:
            ConfigError: ``success`` cannot be called like this, or does not return a bool for each environment.
        """
        try:
            now = success(env, **success_params)
        except TypeError as error:
            raise ConfigError(f"success: {_name(success)}(env, ...) cannot be called: {error}") from error
        if not isinstance(now, torch.Tensor) or now.dtype != torch.bool or now.shape != self._never.shape:
            found = f"{now.dtype} of shape {tuple(now.shape)}" if isinstance(now, torch.Tensor) else type(now).__name__
            wanted = f"a bool tensor of shape {tuple(self._never.shape)}"
            raise ConfigError(f"success: {_name(success)} has to return {wanted}, not {found}")
        self.first_step = torch.where(now & (self.first_step == 0), env.episode_length_buf, self.first_step)
        return self._never


def _name(func: Any) -> str:
    return getattr(func, "__qualname__", type(func).__name__)


@dataclass
class Episode:
    """One whole episode."""

    reward: float
    """Sum of rewards."""
    length: int
    """Steps."""
    success_step: int
    """Step of the first success, 0 for none."""
    end: str
    """Name of the termination term that ended it."""


@dataclass
class Evaluation:
    """Whole episodes in their fixed order."""

    step_dt_s: float
    """Environment step in s."""
    episodes: list[Episode] = field(default_factory=list)
    logs: dict[str, float] = field(default_factory=dict)
    """The environment's logs (``Episode_Reward/...``, ``Metrics/...``), each averaged over its counted episodes."""

    def success_rate(self, count: int | None = None) -> float:
        """Share of the first ``count`` episodes (None: of all) that succeeded at any step."""
        chosen = self.episodes[:count]
        return sum(episode.success_step > 0 for episode in chosen) / len(chosen)

    def rates(self) -> dict[int, float]:
        """Success rate over the first 10, 50, 100, 500, ... episodes, and over all."""
        return {count: self.success_rate(count) for count in milestones(len(self.episodes))}

    def intervals(self) -> dict[int, tuple[float, float]]:
        """95 % confidence intervals (Wilson's) of :meth:`rates`."""
        return {count: wilson_interval(round(rate * count), count) for count, rate in self.rates().items()}

    def summary(self) -> dict[str, Any]:
        """The figures of a report, as plain values."""
        rewards = torch.tensor([episode.reward for episode in self.episodes], dtype=torch.float64)
        lengths = [episode.length for episode in self.episodes]
        times = [episode.success_step * self.step_dt_s for episode in self.episodes if episode.success_step]
        ends: dict[str, int] = {}
        for episode in self.episodes:
            ends[episode.end] = ends.get(episode.end, 0) + 1
        return {
            "episodes": len(self.episodes),
            "success_rate": {str(count): rate for count, rate in self.rates().items()},
            "success_rate_interval": {str(count): list(ends) for count, ends in self.intervals().items()},
            "mean_reward": rewards.mean().item(),
            "std_reward": rewards.std(correction=0).item(),
            "min_reward": rewards.min().item(),
            "max_reward": rewards.max().item(),
            "mean_episode_length": sum(lengths) / len(lengths),
            "min_episode_length": min(lengths),
            "time_to_success_s": sum(times) / len(times) if times else None,
            "terminations": ends,
            "logs": self.logs,
        }


def milestones(total: int) -> list[int]:
    """10, 50, 100, 500, 1000, ... below ``total``, and ``total``."""
    steps = []
    scale = 10
    while scale < total:
        steps += [count for count in (scale, 5 * scale) if count < total]
        scale *= 10
    return [*steps, total]


def add_success_probe(env_cfg: Any, success: Any) -> None:
    """Make an environment configuration watch for success.

    Args:
        env_cfg: gets one more termination term, which ends nothing.
        success: the task's registered ``success``; None to use its termination or metrics term ``success``.

    Raises:
        ConfigError: the task does not say what success is.
    """
    terms = (_term(cfg, "success") for cfg in (env_cfg.terminations, getattr(env_cfg, "metrics", None)))
    term: Any = next((term for term in terms if term is not None), None)
    if success is None and term is None:
        raise ConfigError(
            "this task does not say what success is: register it with success='module:function', or give it a "
            "metrics term or a termination term 'success'"
        )
    if success is None:
        func, params = term.func, dict(term.params)
    elif isinstance(success, dict):
        func, params = success["func"], dict(success.get("params", {}))
    else:
        func, params = success, {}
    if isinstance(func, str):
        func = string_to_callable(func)
    if inspect.isclass(func):
        raise ConfigError(f"success has to be a function of (env, ...), not the class '{func.__name__}'")
    for argument in inspect.signature(func).parameters.values():
        if isinstance(argument.default, SceneEntityCfg):  # names in defaults are resolved like those in params
            params.setdefault(argument.name, copy.deepcopy(argument.default))
    probe = TerminationTermCfg(func=SuccessProbe, params={"success": func, "success_params": params})
    if isinstance(env_cfg.terminations, dict):
        env_cfg.terminations[PROBE] = probe
    else:
        setattr(env_cfg.terminations, PROBE, probe)


def _term(terms: Any, name: str) -> Any:
    return terms.get(name) if isinstance(terms, dict) else getattr(terms, name, None)


def evaluate(env: Any, policy: Any, episodes: int, go_on: Callable[[Evaluation], bool] | None = None) -> Evaluation:
    """Run a policy for whole episodes. The curriculum holds still meanwhile, so that all are of one task.

    Args:
        env: wrapped environment, freshly reset, whose configuration went through :func:`add_success_probe`.
        policy: maps observations to actions.
        episodes: how many episodes to count.
        go_on: called with the episodes so far whenever each environment has run as many of them, but not at the end;
            False ends the evaluation there. Their logs may contain those of further episodes.

    Returns:
        The episodes in their fixed order, up to where ``go_on`` ended them.

    Raises:
        NonFiniteError: an observation or a reward is infinite or NaN.
    """
    inner = env.unwrapped
    probe: SuccessProbe = inner.termination_manager.get_term_cfg(PROBE).func
    names = [name for name in inner.termination_manager.active_terms if name != PROBE]
    rounds = math.ceil(episodes / env.num_envs)
    finished: list[list[Episode]] = [[] for _ in range(env.num_envs)]
    returns = torch.zeros(env.num_envs, dtype=torch.float64, device=env.device)
    lengths = torch.zeros(env.num_envs, dtype=torch.long, device=env.device)
    obs = env.get_observations()
    left, full = env.num_envs * rounds, 0
    logs: dict[str, list[tuple[float, float]]] = {}
    with torch.inference_mode(), _curriculum_held(inner):
        probe.first_step.zero_()
        while left:
            obs, rewards, dones, extras = env.step(policy(obs))
            check_step(env, obs, rewards, extras)
            if hasattr(policy, "reset"):  # the memory of a recurrent one
                policy.reset(dones)
            returns += rewards
            lengths += 1
            ids = dones.nonzero().flatten()
            if not len(ids):
                continue
            ends = [inner.termination_manager.get_term(name)[ids].tolist() for name in names]
            rows = zip(
                ids.tolist(), returns[ids].tolist(), lengths[ids].tolist(), probe.first_step[ids].tolist(), strict=True
            )
            counted = left
            for k, (env_id, total, length, step) in enumerate(rows):
                if len(finished[env_id]) < rounds:
                    end = next((name for name, flags in zip(names, ends, strict=True) if flags[k]), "physics failure")
                    finished[env_id].append(Episode(total, length, step, end))
                    left -= 1
            # A log is a mean over all episodes that ended in this step, or those of them that ``log_counts`` numbers:
            # those beyond the rounds come along.
            if counted > left:
                counts, own = extras.get("log_counts", {}), counted - left
                for key, value in extras.get("log", {}).items():
                    if key.startswith(("Episode_Reward/", "Metrics/")):
                        logs.setdefault(key, []).append((float(value), own * counts.get(key, len(ids)) / len(ids)))
            returns[ids] = 0.0
            lengths[ids] = 0
            probe.first_step[ids] = 0
            if go_on is not None and left and (done := min(map(len, finished))) > full:
                full = done
                so_far = _in_order(inner.step_dt, finished, full, logs)
                if not go_on(so_far):
                    return so_far
    found = _in_order(inner.step_dt, finished, rounds, logs)
    found.episodes = found.episodes[:episodes]
    return found


def _in_order(
    step_dt_s: float, finished: list[list[Episode]], rounds: int, logs: dict[str, list[tuple[float, float]]]
) -> Evaluation:
    """The first episodes of all environments in their fixed order: all first ones by environment, then all second."""
    episodes = [of_env[k] for k in range(rounds) for of_env in finished]
    return Evaluation(step_dt_s, episodes, {key: _merged(key, pairs) for key, pairs in logs.items()})


def _merged(key: str, pairs: list[tuple[float, float]]) -> float:
    """One number of a log's values and the episodes behind each: their mean, or the sum of a count of failures."""
    if key.startswith(FAILURES):
        return sum(value for value, _ in pairs)
    return sum(value * episodes for value, episodes in pairs) / sum(episodes for _, episodes in pairs)


@contextlib.contextmanager
def _curriculum_held(env: Any) -> Iterator[None]:
    """Leave the task as its curriculum has made it so far."""
    manager = getattr(env, "curriculum_manager", None)
    if manager is None:
        yield
        return
    manager.compute = lambda env_ids=None: None
    try:
        yield
    finally:
        del manager.compute
