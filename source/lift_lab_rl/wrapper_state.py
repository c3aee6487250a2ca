"""The state of the gymnasium wrappers around an environment, for a run that is continued.

A wrapper that normalises or counts something holds state, too. Wrappers that only film or check are skipped.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import gymnasium as gym

from lift_lab.utils.errors import StateMismatchError
from lift_lab.utils.state_reader import StateReader
from lift_lab.utils.state_writer import StateWriter

_WITHOUT_STATE = ("OrderEnforcing", "PassiveEnvChecker", "RecordVideo")
"""Wrappers of gymnasium and of this project that change nothing about the episodes."""


def wrapper_states(env: Any) -> tuple[list[Any], list[str]]:
    """Write down the state of the wrappers.

    Args:
        env: an environment inside gymnasium wrappers, or inside a learning library's wrapper of such.

    Returns:
        A node (:mod:`lift_lab.utils.state_writer`) for each wrapper with a state, outermost first; and path and type of
        what could not be written down.
    """
    writer = StateWriter(known={id(inner): f"env.{k}" for k, inner in enumerate(_chain(env))})
    nodes = [writer.object(wrapper, type(wrapper).__qualname__) for wrapper in _with_state(env)]
    return nodes, writer.unsaved


def plan_wrapper_states(env: Any, nodes: list[Any]) -> StateReader:
    """Compare the wrappers with the states of :func:`wrapper_states`.

    Returns:
        The plan, to be applied.

    Raises:
        StateMismatchError: the states are of other wrappers.
    """
    wrappers = list(_with_state(env))
    if len(wrappers) != len(nodes):
        raise StateMismatchError(f"it is of {len(nodes)} wrappers with a state, here are {len(wrappers)}")
    reader = StateReader(known={f"env.{k}": inner for k, inner in enumerate(_chain(env))})
    for wrapper, node in zip(wrappers, nodes, strict=True):
        reader.plan(wrapper, node, type(wrapper).__qualname__)
    return reader


def _chain(env: Any) -> Iterator[Any]:
    """The gymnasium wrappers, outermost first, and the environment inside."""
    inner = env if isinstance(env, gym.Wrapper) else getattr(env, "env", None)
    while isinstance(inner, gym.Wrapper):
        yield inner
        inner = inner.env
    if inner is not None:
        yield inner


def _with_state(env: Any) -> Iterator[gym.Wrapper]:
    for inner in _chain(env):
        if isinstance(inner, gym.Wrapper) and type(inner).__name__ not in _WITHOUT_STATE:
            yield inner
