"""The few numbers of an environment that belong into every checkpoint: how far its curriculum has come."""

from __future__ import annotations

from typing import Any


def manager_env(env: Any) -> Any:
    """The manager-based environment inside the wrapper, or None for an environment of another kind."""
    inner = getattr(env, "unwrapped", None)
    return inner if hasattr(inner, "common_step_counter") else None


def counters(env: Any) -> dict[str, Any]:
    """Progress of a curriculum, small enough for every checkpoint: steps, and the weights that it has changed."""
    if env is None:
        return {}
    found: dict[str, Any] = {"common_step_counter": int(env.common_step_counter)}
    manager = getattr(env, "reward_manager", None)
    if manager is not None:
        changed = env.changed_settings.state_dict()
        weights = {name: changed.get(("reward_manager", name, "weight")) for name in manager.active_terms}
        found["reward_weights"] = {name: float(weight) for name, weight in weights.items() if weight is not None}
        found["configured_weights"] = {name: float(weight) for name, weight in _configured(env).items()}
    return found


def _configured(env: Any) -> dict[str, float]:
    """The weights that the environment's configuration asks for."""
    rewards = env.cfg.rewards
    read = rewards.get if isinstance(rewards, dict) else lambda name: getattr(rewards, name, None)
    return {name: term.weight for name in env.reward_manager.active_terms if (term := read(name)) is not None}


def load_counters(env: Any, saved: dict[str, Any]) -> None:
    """Continue a curriculum.

    The checkpoint's weights are used for terms that this environment's curriculum may change. A weight that the user
    has changed in the configuration since then stays.
    """
    if "common_step_counter" in saved:
        env.common_step_counter = saved["common_step_counter"]
    manager, curriculum = (getattr(env, f"{name}_manager", None) for name in ("reward", "curriculum"))
    if manager is None or curriculum is None or "reward_weights" not in saved:
        return
    configured = _configured(env)
    for name, weight in saved["reward_weights"].items():
        same = name in configured and configured[name] == saved["configured_weights"].get(name)
        if same and curriculum.may_change_weight(name):
            manager.get_term_cfg(name).weight = weight
