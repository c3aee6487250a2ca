"""Find the terms of an environment whose numbers are infinite or NaN."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import torch

from lift_lab.utils.errors import LiftLabError

from .counters import manager_env


class NonFiniteError(LiftLabError):
    """A number in a training is infinite or NaN."""


def kind_of(values: torch.Tensor) -> str:
    """``"NaN"`` or ``"infinite"``, for a tensor with at least one number that is not finite."""
    return "NaN" if bool(values.isnan().any()) else "infinite"


def observation_terms(env: Any, group: str, bad: torch.Tensor) -> list[str]:
    """Observation terms that hold marked entries.

    Args:
        env: manager-based environment; None for another.
        group: name of the group; ``group/term`` for a group that is a dict.
        bad: marked entries of the group's observation, shape (num_envs, ...).

    Returns:
        Names with their group; nothing if the environment does not tell.
    """
    manager = getattr(env, "observation_manager", None)
    name, _, term = group.partition("/")
    if manager is None or name not in manager.active_terms:
        return []
    names = [term] if term else manager.active_terms[name]
    parts: Any = [bad]
    if not term:
        axis = manager.group_obs_concatenate_dim[name]
        lengths = [shape[axis - 1 if axis > 0 else axis] for shape in manager.group_obs_term_dim[name]]
        parts = bad.split(lengths, dim=axis)
    found = [own for own, part in zip(names, parts, strict=True) if bool(part.any())]
    return [f"observation term '{own}' of group '{name}'" for own in found]


def reward_terms(env: Any, envs: torch.Tensor, logs: Iterable[dict[str, Any]] = ()) -> list[str]:
    """Reward terms that are not finite: in the running episodes of some environments, or in logs of ended ones.

    Args:
        env: manager-based environment; None for another.
        envs: which environments, a bool tensor of shape (num_envs,).
        logs: the environment's logs since the reward was last finite.

    Returns:
        Their names; nothing if every term is finite.
    """
    manager = getattr(env, "reward_manager", None)
    if manager is None:
        return []
    logs = list(logs)
    found = []
    for name in manager.active_terms:
        sums = manager.episode_sum(name)
        logged = [float(log[f"Episode_Reward/{name}"]) for log in logs if f"Episode_Reward/{name}" in log]
        in_logs = not all(map(math.isfinite, logged))
        if in_logs or not bool(sums[envs.to(sums.device)].isfinite().all()):
            found.append(f"reward term '{name}'")
    return found


def check_step(env: Any, obs: Any, rewards: torch.Tensor, extras: dict[str, Any]) -> None:
    """Check the values that a step returned; waits for the device.

    Args:
        env: the environment or a wrapper of it.
        obs: observations, a dict of tensors or of dicts of them.
        rewards: shape (num_envs,).
        extras: the step's.

    Raises:
        NonFiniteError: an observation or a reward is infinite or NaN; names the term.
    """
    numbers = {} if obs is None else leaves(obs)
    looks = [extremes_of(rewards), *map(extremes_of, numbers.values())]
    if all(math.isfinite(number) for row in torch.stack(looks).tolist() for number in row):
        return
    inner = manager_env(env)
    for name, values in {"": rewards, **numbers}.items():
        bad = ~torch.isfinite(values)
        if not bool(bad.any()):
            continue
        if name:
            terms = observation_terms(inner, name, bad) or [f"observation group '{name}'"]
        else:
            terms = reward_terms(inner, bad, [extras.get("log", {})]) or ["the sum of the rewards"]
        raise NonFiniteError(sentence(terms, values, bad))


def leaves(obs: Any) -> dict[str, torch.Tensor]:
    """Groups of observations by name; terms of a group that is a dict as ``group/term``."""
    found = {}
    for name, value in obs.items():
        inner = {name: value} if isinstance(value, torch.Tensor) else {f"{name}/{key}": v for key, v in value.items()}
        found.update(inner)
    return found


def extremes_of(values: torch.Tensor) -> torch.Tensor:
    """Least and greatest entry, NaN where any is, shape (2,); zeros for no or whole numbers."""
    if not values.is_floating_point() or not values.numel():
        return torch.zeros(2, device=values.device)
    return torch.stack(torch.aminmax(values.detach())).float()


def sentence(terms: list[str], values: torch.Tensor, bad: torch.Tensor) -> str:
    """Return the terms that are not finite, with their environments; ``bad`` marks them in ``values``, (num_envs,
    ...)."""
    envs = bad.reshape(len(bad), -1).any(1).nonzero().flatten().tolist()
    where = f"environment {envs[0]}" if len(envs) == 1 else f"{len(envs)} environments (the first is {envs[0]})"
    return f"{listed(terms)} is {kind_of(values[bad])} in {where}"


def listed(terms: list[str]) -> str:
    """At most three terms, and how many more."""
    return " and ".join(terms[:3]) + (f" and {len(terms) - 3} more" if len(terms) > 3 else "")
