"""The few numbers of an environment that belong into every checkpoint: how far its curriculum has come."""

from __future__ import annotations

import re
from typing import Any


def manager_env(env: Any) -> Any:
    """The manager-based environment inside the wrapper, or None for an environment of another kind."""
    inner = getattr(env, "unwrapped", None)
    return inner if hasattr(inner, "common_step_counter") else None


def counters(env: Any) -> dict[str, Any]:
    """What a curriculum has done so far, small enough for every checkpoint."""
    if env is None:
        return {}
    found: dict[str, Any] = {"common_step_counter": int(env.common_step_counter)}
    manager = getattr(env, "reward_manager", None)
    if manager is not None:
        terms = {name: manager.get_term_cfg(name) for name in manager.active_terms}
        found["reward_weights"] = {name: float(cfg.weight) for name, cfg in terms.items()}
        found["configured_weights"] = {name: float(weight) for name, weight in _configured(env, terms).items()}
    return found


def _configured(env: Any, names: Any) -> dict[str, float]:
    """The weights that the environment's configuration asks for."""
    rewards = env.cfg.rewards
    read = rewards.get if isinstance(rewards, dict) else lambda name: getattr(rewards, name, None)
    return {name: term.weight for name in names if (term := read(name)) is not None}


def load_counters(env: Any, saved: dict[str, Any]) -> None:
    """Continue a curriculum.

    Weights are those of the checkpoint where a curriculum term of this environment names the reward term in its
    parameters. A weight that no curriculum changes, or that the user configured anew since then, is left alone.
    """
    if "common_step_counter" in saved:
        env.common_step_counter = saved["common_step_counter"]
    manager = getattr(env, "reward_manager", None)
    if manager is None or "reward_weights" not in saved:
        return
    configured, scheduled = _configured(env, manager.active_terms), _named_in_curriculum(env)
    for name, weight in saved["reward_weights"].items():
        if name in scheduled and name in configured and configured[name] == saved["configured_weights"].get(name):
            manager.get_term_cfg(name).weight = weight


def _named_in_curriculum(env: Any) -> set[str]:
    """Every word in the parameters of the curriculum's terms: ``alive`` of ``rewards.alive.weight``, too."""
    manager = getattr(env, "curriculum_manager", None)
    if manager is None:
        return set()
    return {word for name in manager.active_terms for word in _words(manager.get_term_cfg(name).params)}


def _words(value: Any) -> list[str]:
    if isinstance(value, str):
        return re.findall(r"\w+", value)
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, (list, tuple)) else ()
    return [word for part in parts for word in _words(part)]
