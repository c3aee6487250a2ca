"""Ranges of the numbers in configuration classes.

A configuration class declares them beside its fields, and ``validate`` checks them::

    @configclass
    class MotorCfg:
        gear: float = 1.0
        ratio: float = 0.5
        _ranges: ClassVar[Ranges] = {"gear ratio": POSITIVE}

A key names one field or several, separated by spaces. A sub-class inherits the ranges and may declare others. A number
of no declared range, such as one in a term's ``params``, may be anything but NaN.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from .config_update import field_hints
from .errors import quote
from .field_kinds import kind_problem

_NUMBERS = (int, float, np.integer, np.floating)


@dataclass(frozen=True)
class Range:
    """Range of the numbers that a field takes, and of each entry of a list, tuple or dictionary."""

    low: float = -math.inf
    """Least number."""
    high: float = math.inf
    """Greatest number."""
    above: bool = False
    """Whether ``low`` itself is excluded."""
    below: bool = False
    """Whether ``high`` itself is excluded."""
    infinite: bool = False
    """Whether infinite numbers are taken."""
    whole: bool = False
    """Whether only whole numbers are."""
    ascending: bool = False
    """Whether a pair needs its lower number first."""
    open_ended: bool = False
    """Whether an entry of a list may be None, for no limit."""
    least_entries: int = 0
    """Entries that a list needs."""
    also: tuple[float, ...] = ()
    """Numbers outside of the range that are taken, too."""

    def problem(self, path: str, value: Any) -> str | None:
        """Describe in one line what is wrong with a value; None if nothing is.

        Args:
            path: name of the field.
            value: a number, or a list, tuple, dictionary or tensor of numbers. Text is not a number. Values of other
                types are not checked.
        """
        if isinstance(value, (str, bool)):
            return f"{path} is {value!r}; it must be {self}"
        if isinstance(value, (list, tuple)) and len(value) < self.least_entries:
            return f"{path} is empty; it needs at least {self.least_entries} entry"
        if isinstance(value, (list, tuple, dict)):
            entries = value.items() if isinstance(value, dict) else enumerate(value)
            for key, entry in entries:
                inner = f"{path}.{key}" if isinstance(value, dict) else f"{path}[{key}]"
                if entry is None and self.open_ended:
                    continue
                if entry is None:
                    return f"{inner} is null; it must be {self}"
                taken = dataclasses.replace(self, ascending=False) if _is_number(entry) else self
                found = taken.problem(inner, entry)
                if found is not None:
                    return found
        numbers = isinstance(value, (list, tuple)) and all(_is_number(entry) for entry in value)
        if self.ascending and _is_number(value):
            return f"{path} is {_text(value)}; it needs two numbers, (low, high)"
        if self.ascending and numbers:
            if len(value) != 2:
                return f"{path} has {len(value)} numbers; it needs two, (low, high)"
            if value[0] > value[1]:
                return (
                    f"{path} is ({_text(value[0])}, {_text(value[1])}); the first number must not be above the second"
                )
        for name, number in () if isinstance(value, (list, tuple, dict)) else numbers_in(path, value):
            if self.whole and not isinstance(number, (int, np.integer)) and math.isfinite(number):
                return f"{name} is {float(number)}; it must be a whole number, {self}"
            if not self._takes(number):
                return f"{name} is {_text(number)}; it must be {self}"
        return None

    def _takes(self, number: Any) -> bool:
        if number in self.also:
            return True
        if math.isnan(number) or (math.isinf(number) and not self.infinite):
            return False
        if self.whole and not isinstance(number, (int, np.integer)):
            return False
        low = number > self.low if self.above else number >= self.low
        return bool(low and (number < self.high if self.below else number <= self.high))

    def __str__(self) -> str:
        bounds = []
        if self.low > -math.inf:
            bounds.append(f"{'above' if self.above else 'at least'} {_text(self.low)}")
        if self.high < math.inf:
            bounds.append(f"{'below' if self.below else 'at most'} {_text(self.high)}")
        kind = ["whole"] if self.whole and not bounds else []
        if not self.infinite and self.high == math.inf and not self.whole:
            kind = ["finite"]
        text = " and ".join([*kind, *bounds]) or "a number"
        return ", or ".join([text, *(_text(number) for number in self.also)])


def _is_number(value: Any) -> bool:
    return isinstance(value, _NUMBERS)


def _text(number: Any) -> str:
    """A number in full if it is whole (1e+06 and more would lose digits), else as short as it is exact enough."""
    whole = math.isfinite(number) and number == int(number) and abs(number) < 1e15
    return str(int(number)) if whole else f"{number:g}"


@dataclass(frozen=True)
class Choices:
    """Names that a field takes, asked for whenever a configuration is checked."""

    names: Callable[[], Sequence[str]]
    """Gives the names."""

    def problem(self, path: str, value: Any) -> str | None:
        """Describe in one line what is wrong with a value; None if nothing is."""
        return None if value is None or value in self.names() else f"{path} is {value!r}; it must be {self}"

    def __str__(self) -> str:
        return f"one of {quote(self.names())}"


Ranges = Mapping[str, Range | Choices]
"""Ranges by the names of fields; a key may name several, separated by spaces."""

FINITE = Range()
"""Any number but NaN and infinity."""
POSITIVE = Range(0.0, above=True)
"""Above 0, finite."""
POSITIVE_OR_INF = Range(0.0, above=True, infinite=True)
"""Above 0."""
NOT_NEGATIVE = Range(0.0)
"""At least 0, finite."""
NOT_NEGATIVE_OR_INF = Range(0.0, infinite=True)
"""At least 0."""
FRACTION = Range(0.0, 1.0)
"""From 0 to 1."""
COUNT = Range(1, whole=True)
"""Whole, at least 1."""
INT32_COUNT = Range(1, 2**31 - 1, whole=True)
"""Whole, at least 1, and small enough for the engines' integers of 32 bits."""
COUNT_OR_ZERO = Range(0, whole=True)
"""Whole, at least 0."""
WHOLE = Range(whole=True)
"""Any whole number."""
SIZES = Range(1, whole=True, least_entries=1)
"""A list of at least one count."""
SPAN = Range(ascending=True)
"""A pair (low, high) of finite numbers."""
SPAN_OR_INF = Range(ascending=True, infinite=True)
"""A pair (low, high) of numbers."""
POSITIVE_SPAN = Range(0.0, ascending=True)
"""A pair (low, high) of finite numbers of at least 0."""
POSITIVE_SPAN_OR_INF = Range(0.0, ascending=True, infinite=True)
"""A pair (low, high) of numbers of at least 0."""
SEED = Range(0, 2**32 - 1, whole=True, also=(-1,))
"""Seed of random numbers; -1 draws one."""


@functools.cache
def ranges_of(cls: type) -> dict[str, Range | Choices]:
    """Declared ranges of a configuration class, those of its bases included."""
    found: dict[str, Range | Choices] = {}
    for base in reversed(cls.__mro__):
        for names, taken in vars(base).get("_ranges", {}).items():
            found.update(dict.fromkeys(names.split(), taken))
    return found


@functools.cache
def param_ranges(func: Any) -> dict[str, Range]:
    """Ranges that a term declares for its arguments.

    Args:
        func: a function, or a class with ``__call__``, whose arguments are annotated as ``Annotated[float, POSITIVE]``.
    """
    found = {}
    for name, annotation in _annotated(func).items():
        for note in annotation.__metadata__:
            if isinstance(note, Range):
                found[name] = note
    return found


@functools.cache
def nullable_params(func: Any) -> frozenset[str]:
    """Arguments with a declared range that may be None."""
    annotations = _annotated(func).items()
    return frozenset(name for name, hint in annotations if type(None) in typing.get_args(hint.__origin__))


def _annotated(func: Any) -> dict[str, Any]:
    """Annotations of a term's arguments that are ``Annotated``; those that cannot be evaluated are left out."""
    call = func.__call__ if isinstance(func, type) else func
    found = {}
    for name, annotation in getattr(call, "__annotations__", {}).items():
        if isinstance(annotation, str) and annotation.startswith("Annotated["):
            try:
                annotation = eval(annotation, getattr(call, "__globals__", {}))
            except (NameError, AttributeError, TypeError, SyntaxError):
                continue
        if hasattr(annotation, "__metadata__"):
            found[name] = annotation
    return found


@functools.cache
def may_be_none(cls: type, name: str) -> bool:
    """Whether a field may be None.

    Fields with a declared range, and fields that hold a configuration in one of this project's own classes, follow
    their annotation. Everything else may be None: a task removes a term or an asset that way.
    """
    hint = field_hints(cls).get(name)
    if hint is None or hint is Any or type(None) in typing.get_args(hint):
        return True
    if name in ranges_of(cls):
        return False
    for base in cls.__mro__:
        ours = base.__module__.partition(".")[0] in ("lift_lab", "lift_lab_rl")
        if ours and name in vars(base).get("__annotations__", {}):
            hint = field_hints(base).get(name)
            if dataclasses.is_dataclass(hint) and not _is_term(hint):
                return False
    return True


def _is_term(cls: Any) -> bool:
    """Whether a class configures a term of a manager, which may be left out."""
    return any(base.__name__.endswith(("TermCfg", "TermBaseCfg")) for base in cls.__mro__)


def numbers_in(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Numbers of a value with their paths, also in lists, tuples, dictionaries, tensors and arrays."""
    if isinstance(value, bool):
        return
    if _is_number(value):
        yield path, value
    elif isinstance(value, (list, tuple)):
        for index, entry in enumerate(value):
            yield from numbers_in(f"{path}[{index}]", entry)
    elif isinstance(value, dict):
        for key, entry in value.items():
            yield from numbers_in(f"{path}.{key}", entry)
    elif isinstance(value, (torch.Tensor, np.ndarray)) and np.prod(value.shape) < 10_000:
        yield from numbers_in(path, value.tolist())


def first_problem(cfg: Any, path: str = "") -> str | None:
    """The first number or None in a configuration that its field does not take, in one line; None if all are taken.

    Args:
        cfg: a configuration, or a list or dictionary of some.
        path: where it is, put before the names.
    """
    if dataclasses.is_dataclass(cfg) and not isinstance(cfg, type):
        ranges, cls = ranges_of(type(cfg)), type(cfg)
        func: Any = getattr(cfg, "func", None)
        params = param_ranges(func) if callable(func) else {}
        for name, value in vars(cfg).items():
            inner = f"{path}.{name}" if path else name
            if name == "params" and isinstance(value, dict):
                for key in params.keys() & value.keys():
                    problem = params[key].problem(f"{inner}.{key}", value[key])
                    if value[key] is None and key not in nullable_params(func):
                        problem = f"{inner}.{key} is null; it must be {params[key]}"
                    if problem is not None:
                        return problem
            if value is None and not may_be_none(cls, name):
                return f"{inner} is null; " + (f"it must be {ranges[name]}" if name in ranges else "it is needed")
            known = ranges.get(name)
            problem = None if known is not None and _is_number(value) else kind_problem(cls, name, inner, value)
            if problem is not None:
                return problem
            problem = first_problem(value, inner) if known is None else known.problem(inner, value)
            if problem is not None:
                return problem if known is None or may_be_none(cls, name) is False else f"{problem}, or null"
        return None
    if isinstance(cfg, (list, tuple, dict)):
        entries = cfg.items() if isinstance(cfg, dict) else enumerate(cfg)
        for key, entry in entries:
            inner = f"{path}[{key}]" if not isinstance(cfg, dict) else f"{path}.{key}" if path else str(key)
            problem = first_problem(entry, inner)
            if problem is not None:
                return problem
        return None
    for name, number in numbers_in(path, cfg):
        if math.isnan(number):
            return f"{name} is nan; it must be a number"
    return None
