"""Values that several terms share, computed once while nothing moves."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")


def once_a_step(compute: Callable[Concatenate[Any, P], T]) -> Callable[Concatenate[Any, P], T]:
    """Let a function of the environment compute once for all terms that ask while nothing moves.

    That is while an environment calls terminations, rewards and metrics, and again while it calls observations: terms
    that only read. The values are in ``env.step_cache`` then, which is None at any other time: the function computes
    at every call. So it uses all values that a reset, an event, a command or a script wrote.

    Args:
        compute: takes the environment, then names and numbers (hashable values).

    Returns:
        The function. Calls with the same arguments in the same phase of a step return the same object: do not write
        into it.
    """

    @functools.wraps(compute)
    def read(env: Any, *args: P.args, **kwargs: P.kwargs) -> T:
        values = env.step_cache
        if values is None:
            return compute(env, *args, **kwargs)
        key = (compute, args, *kwargs.items())
        if key not in values:
            values[key] = compute(env, *args, **kwargs)
        return values[key]

    return read
