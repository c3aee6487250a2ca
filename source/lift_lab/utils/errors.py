"""Errors for users, and a helper that proposes the nearest valid names.

Command lines print a :class:`LiftLabError` as one line and exit with status 2. Every sub-class is also the builtin
that a caller would naturally catch.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_MOST_LISTED = 12


class LiftLabError(Exception):
    """Base of the errors that are addressed to the user."""

    def __str__(self) -> str:
        return Exception.__str__(self)  # KeyError would quote its message


class ConfigError(LiftLabError, ValueError):
    """A configuration holds a wrong value."""


class ConfigTypeError(LiftLabError, TypeError):
    """A configuration, or a function that it names, gives a value of the wrong type."""


class NotCallableError(LiftLabError, AttributeError):
    """A configuration names something that cannot be called."""


class NoCallError(LiftLabError, NotImplementedError):
    """A class of a term has no ``__call__``."""


class ShapeError(LiftLabError, RuntimeError):
    """Shapes do not fit together."""


class UnknownFieldError(ConfigError, KeyError):
    """A configuration has no entry of that name."""


class MissingFieldError(LiftLabError, TypeError):
    """A configuration leaves entries at ``MISSING`` that must be set."""


class UnknownAttributeError(LiftLabError, AttributeError):
    """An object has nothing of that name."""


class NotFoundError(LiftLabError, KeyError):
    """Nothing of that name exists."""


class FileError(LiftLabError, FileNotFoundError):
    """A file that is needed does not exist."""


class MissingPackageError(LiftLabError, ImportError):
    """A package that a feature needs is not installed."""


class PhysicsError(LiftLabError, RuntimeError):
    """The physics engine cannot do what was asked."""


class StateMismatchError(LiftLabError, ValueError):
    """A saved state is of something else."""


def suggest(name: str, choices: Iterable[str], n: int = 3) -> str:
    """Propose the nearest valid names for one that is not valid.

    Args:
        name: what was asked for.
        choices: the valid names.
        n: how many close matches to propose at most.

    Returns:
        ``"did you mean 'a', 'b'?"``, or without a close match ``"choose one of: 'a', 'b', ..."`` (cut short when
        there are many), or ``"there are none to choose from"``.
    """
    choices = list(dict.fromkeys(str(choice) for choice in choices))
    if not choices:
        return "there are none to choose from"
    closeness = {choice: _closeness(str(name).lower(), choice.lower()) for choice in choices}
    close = sorted((choice for choice in choices if closeness[choice] >= 0.6), key=lambda choice: -closeness[choice])
    if close:
        return f"did you mean {quote(close[:n])}?"
    return f"choose one of: {quote(choices)}"


def _closeness(a: str, b: str) -> float:
    """Likeness of two names in [0, 1]; a name that contains the other is close."""
    ratio = difflib.SequenceMatcher(None, a, b).ratio()
    contained = min(len(a), len(b)) >= 3 and (a in b or b in a)
    return max(ratio, 0.6) if contained else ratio


def quote(names: Iterable[str], most: int = _MOST_LISTED) -> str:
    """Names in quotes, separated by commas, cut after ``most``."""
    names = list(names)
    text = ", ".join(f"'{name}'" for name in names[:most])
    return text if len(names) <= most else f"{text}, ... ({len(names) - most} more)"
