"""Contents of ``model_N.pt``: networks, optimisers, and the counters of curriculum and curiosity."""

from __future__ import annotations

from typing import Any

from rsl_rl.algorithms import PPO

from lift_lab.utils.errors import ConfigError
from lift_lab_rl.counters import counters, load_counters, manager_env

from .checkpoint_file import check_fit
from .ema import AVERAGE, LAST
from .ppo import LiftLabPPO
from .run_files import trained_with
from .symmetric_policy import SymmetricMlp, check_mirror_state, is_symmetric, with_mirror


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
    content = _with_maps(alg, path, content)
    try:
        check_fit(alg, content, parts, strict)
        return alg.load(content, parts, strict)
    except (RuntimeError, KeyError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split())[:200].rstrip(" .")
        made_with = trained_with(path)
        hint = f"; it was trained with {made_with}" if made_with else ""
        raise ConfigError(f"checkpoint '{path}' does not fit this task's networks: {reason}{hint}") from error


def _with_maps(alg: PPO, path: str, content: dict[str, Any]) -> dict[str, Any]:
    """A checkpoint's content, with the maps of the algorithm's symmetric policy where it is of another policy."""
    saved = {name: content[name] for name in (LAST, AVERAGE) if isinstance(content.get(name), dict)}
    if isinstance(alg.actor, SymmetricMlp):
        mirror = alg.actor.mirror
        return content | {name: with_mirror(state, mirror) for name, state in saved.items()}
    if any(is_symmetric(state) for state in saved.values()):
        raise ConfigError(
            f"checkpoint '{path}' is of an exactly symmetric policy: set "
            "agent.algorithm.symmetry_cfg.average_policy=true"
        )
    return content


def take_symmetry(alg: PPO, path: str, state: dict[str, Any]) -> None:
    """Make the actor a symmetric policy where a checkpoint's is one, to act as it does.

    Args:
        alg: the algorithm.
        path: file of the checkpoint, for the message.
        state: the saved state of its actor.

    Raises:
        ConfigError: the algorithm is rsl_rl's, or the maps are not valid.
    """
    if is_symmetric(state):
        check_mirror_state(state, path)
        if not isinstance(alg, LiftLabPPO):
            raise ConfigError(
                f"checkpoint '{path}' is of an exactly symmetric policy: set agent.algorithm.class_name=LiftLabPPO"
            )
        alg.average_with_images()
    elif isinstance(alg, LiftLabPPO) and isinstance(alg.actor, SymmetricMlp) and not alg.averages_by_setting:
        alg.actor.mirror.clear()  # the symmetric policy that acted before was another file's


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
