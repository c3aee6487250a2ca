"""Contents of ``model_N.pt``: networks, optimisers, and the counters of curriculum and curiosity."""

from __future__ import annotations

from typing import Any

from rsl_rl.algorithms import PPO

from lift_lab.utils.errors import ConfigError
from lift_lab_rl.counters import counters, load_counters, manager_env

from .checkpoint_file import check_fit
from .run_files import trained_with


def model_content(alg: PPO, env: Any, iteration: int, infos: dict[str, Any] | None = None) -> dict[str, Any]:
    """The entries of a checkpoint.

    Args:
        alg: the algorithm.
        env: environment, as rsl_rl sees it.
        iteration: iterations finished.
        infos: more to keep under ``infos``; tensors and plain values.
    """
    content = alg.save()
    content["iter"] = iteration
    content["infos"] = {"env_state": counters(manager_env(env)), **(infos or {})}
    if alg.rnd:
        content["infos"]["rnd"] = {"update_counter": alg.rnd.update_counter, "weight": alg.rnd.weight}
    return content


def load_networks(alg: PPO, path: str, content: dict[str, Any], parts: dict[str, bool] | None, strict: bool) -> bool:
    """Load networks and optimisers after a check that they fit.

    Args:
        alg: the algorithm.
        path: file of the checkpoint, for the message.
        content: its entries.
        parts: parts to load; None for all.
        strict: whether parameters may neither be missing nor be left over.

    Returns:
        Whether the iteration is one of the parts.

    Raises:
        ConfigError: they do not fit; nothing was loaded.
    """
    try:
        check_fit(alg, content, parts, strict)
        return alg.load(content, parts, strict)
    except (RuntimeError, KeyError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split())[:200].rstrip(" .")
        made_with = trained_with(path)
        hint = f"; it was trained with {made_with}" if made_with else ""
        raise ConfigError(f"checkpoint '{path}' does not fit this task's networks: {reason}{hint}") from error


def load_infos(alg: PPO, env: Any, content: dict[str, Any]) -> dict[str, Any]:
    """Load the counters; returns the ``infos`` of a checkpoint."""
    infos = content.get("infos") or {}
    inner = manager_env(env)
    if inner is not None:
        load_counters(inner, infos.get("env_state", {}))
    if alg.rnd:
        for name, value in infos.get("rnd", {}).items():
            setattr(alg.rnd, name, value)
    return infos
