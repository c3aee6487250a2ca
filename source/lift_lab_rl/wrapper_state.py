"""The state of the gymnasium wrappers around an environment, for a run that is continued.

A wrapper that normalises or counts something holds state, too. Those that only film or check are left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium as gym

from lift_lab.utils.errors import StateMismatchError

from .state_capture import Capture
from .state_restore import Restore

_WITHOUT_STATE = ("OrderEnforcing", "PassiveEnvChecker", "RecordVideo")
"""Wrappers of gymnasium and of this project that change nothing about the episodes."""


def wrapper_states(env: Any) -> tuple[list[Any], list[str]]:
    """Write down the state of the wrappers.

    Args:
        env: an environment inside gymnasium wrappers, or inside a learning library's wrapper of such.

    Returns:
        A node (see :mod:`.state_nodes`) for each wrapper with a state, outermost first; and path and type of what could
        not be written down.
    """
    nodes, unsaved = [], []
    for wrapper in _wrappers(env):
        capture = Capture(set(), lambda value, wrapper=wrapper: isinstance(value, gym.Env) and value is not wrapper)
        nodes.append(capture.node(wrapper, type(wrapper).__qualname__))
        unsaved += capture.unsaved
    return nodes, unsaved


def plan_wrapper_states(env: Any, nodes: list[Any]) -> list[Restore]:
    """Compare the wrappers with the states of :func:`wrapper_states`.

    Returns:
        Plans; :meth:`~lift_lab_rl.state_restore.Restore.apply` each.

    Raises:
        StateMismatchError: the states are of other wrappers.
    """
    wrappers = list(_wrappers(env))
    if len(wrappers) != len(nodes):
        raise StateMismatchError(f"it is of {len(nodes)} wrappers with a state, here are {len(wrappers)}")
    plans = []
    for wrapper, node in zip(wrappers, nodes, strict=True):
        plan = Restore(set(), lambda value, wrapper=wrapper: isinstance(value, gym.Env) and value is not wrapper, "cpu")
        plan.plan(wrapper, node, type(wrapper).__qualname__)
        plans.append(plan)
    return plans


def _wrappers(env: Any) -> Iterator[gym.Wrapper]:
    """The gymnasium wrappers that hold a state, outermost first."""
    inner = env if isinstance(env, gym.Wrapper) else getattr(env, "env", None)
    while isinstance(inner, gym.Wrapper):
        if type(inner).__name__ not in _WITHOUT_STATE:
            yield inner
        inner = inner.env
