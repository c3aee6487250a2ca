"""Whether a value is of the kind that a field of a configuration holds: a number is no configuration, None no class."""

from __future__ import annotations

import collections.abc
import dataclasses
import functools
from collections.abc import Mapping
from typing import Any, get_args, get_origin

from .config_update import _alternatives, field_hints

_PLAIN = (bool, int, float, str)
_CALLABLE = (type, collections.abc.Callable)


@functools.cache
def _options(cls: type, name: str) -> tuple[tuple[Any, ...], bool]:
    """Types of a field, without None; and whether None is one. None are known of a field that is not ours.

    A field is ours if a class of this project annotates it, and if no sub-class elsewhere annotates it otherwise.
    """
    nearest: Any = None
    for base in cls.__mro__:
        if name in vars(base).get("__annotations__", {}):
            hint = field_hints(base).get(name)
            nearest = hint if nearest is None else nearest
            if base.__module__.partition(".")[0] in ("lift_lab", "lift_lab_rl"):
                options = () if hint is None or hint != nearest else _alternatives(hint)
                return tuple(option for option in options if option is not type(None)), type(None) in options
    return (), True


def kind_problem(cls: type, name: str, path: str, value: Any) -> str | None:
    """Describe in one line what is wrong with the kind of a field's value; None if nothing is or nothing is known.

    Only clear mistakes are problems. Examples are a number or text in place of a configuration, a number in place of a
    list, and a value that cannot be called in place of a function.

    Args:
        cls: class of the configuration.
        name: name of the field.
        path: of the field, for the message.
        value: of the field.
    """
    options, may_be_none = _options(cls, name)
    kinds = {get_origin(option) or option for option in options}
    if not kinds or (value is None and may_be_none) or value is dataclasses.MISSING:
        return None
    if kinds <= set(_CALLABLE):
        named = "a class" if kinds == {type} else "a class or a function"
        fits = isinstance(value, type) if kinds == {type} else callable(value)
        return None if fits or isinstance(value, str) else f"{path} is {_shown(value)}; it needs {named}"
    if all(kind is object or dataclasses.is_dataclass(kind) for kind in kinds):
        wrong = isinstance(value, _PLAIN) or (isinstance(value, (list, tuple)) and object not in kinds)
        names = [kind.__name__ for kind in kinds if kind is not object] or ["configuration"]
        return f"{path} is {_shown(value)}; it needs a {' or '.join(sorted(names))}" if wrong else None
    if kinds == {dict}:
        if isinstance(value, (*_PLAIN, list, tuple)):
            return f"{path} is {_shown(value)}; it needs a dictionary"
        entry = get_args(options[0])[1:]
        if entry and dataclasses.is_dataclass(entry[0]) and isinstance(value, Mapping):
            for key, item in value.items():
                if item is None or isinstance(item, (*_PLAIN, list, tuple)):
                    cls_name = getattr(entry[0], "__name__", "configuration")
                    return f"{path}.{key} is {_shown(item)}; it needs a {cls_name}"
        return None
    if kinds <= {list, tuple} and isinstance(value, (bool, int, float)):
        return f"{path} is {_shown(value)}; it needs a list"
    return None


def _shown(value: Any) -> str:
    text = "null" if value is None else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
