"""Update of a configuration from a nested dictionary; every value is checked.

A value is accepted if it fits the value that it replaces, or else the field's annotation. Annotations also guide
conversion where there is no value to compare with (None or MISSING). They are read leniently: one that cannot be
evaluated, because its names exist for type checkers only, is as good as none.
"""

from __future__ import annotations

import copy
import dataclasses
import enum
import functools
import sys
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING
from pathlib import PurePath
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import numpy as np
import torch

from .errors import ConfigError, UnknownFieldError, suggest
from .string import is_function_like, is_lambda_expression, string_to_callable, string_to_slice

MISSING_TEXT = "???"
"""Text of ``MISSING`` in a dictionary (as OmegaConf writes it)."""

_REAL = (int, float, np.integer, np.floating)
_NO = object()  # "does not fit"


def update_class_from_dict(obj: Any, data: Mapping[str, Any], _ns: str = "") -> None:
    """Set values of a configuration in place from a nested dictionary.

    Values are converted: an int to a float, ``"module:name"`` to a callable, a list to a tuple, ``"slice(a,b,c)"`` to a
    slice, ``"???"`` to ``MISSING``. A None whose annotation is more than plain types takes any value. A list replaces a
    list. A list of dictionaries updates a list of as many configurations. Keys may be added to an empty dictionary
    only.

    Args:
        obj: a configuration or a dictionary.
        data: nested dictionary; fields without a key keep their values.
        _ns: path of ``obj``, for messages.

    Raises:
        TypeError: ``data`` is not a dictionary.
        ConfigError: (a ValueError) a value does not fit; names the path. An unknown key raises the sub-class
            ``UnknownFieldError`` (also a KeyError) with the closest names.
    """
    if not isinstance(data, Mapping):
        raise TypeError(f"{_ns or type(obj).__name__}: expected a dictionary, got {type(data).__name__} {data!r}")
    is_dict = isinstance(obj, dict)
    hints = {} if is_dict else field_hints(type(obj))
    open_ended = is_dict and not obj
    for key, value in data.items():
        path = f"{_ns}.{key}" if _ns else str(key)
        known = obj if is_dict else vars(obj)
        if key not in known and not open_ended:
            owner = f" in {type(obj).__name__}" if not is_dict else ""
            raise UnknownFieldError(f"{path}: no such key{owner}; {suggest(str(key), map(str, known))}")
        current = known.get(key)
        if isinstance(value, Mapping) and _is_nested(current):
            update_class_from_dict(current, value, path)
            continue
        new = _coerce(value, current, hints.get(key), path, typed=not is_dict)
        if is_dict:
            obj[key] = new
        else:
            setattr(obj, key, new)


def _is_nested(value: Any) -> bool:
    if isinstance(value, dict):
        return True
    atomic = (torch.Tensor, enum.Enum, PurePath, type(MISSING))
    return hasattr(value, "__dict__") and not is_function_like(value) and not isinstance(value, atomic)


##
# One value
##


def _coerce(value: Any, current: Any, hint: Any, path: str, typed: bool) -> Any:
    """``value`` in the form in which it may replace ``current``."""
    if value is None or value is MISSING:
        return value
    if isinstance(value, str) and value == MISSING_TEXT:
        return MISSING
    empty = current is None or current is MISSING
    choices = _literal_choices(hint)
    if choices is not None and (empty or current in choices):
        if value in choices:
            return value
        raise ConfigError(f"{path}: {value!r} is not a choice; {suggest(str(value), map(str, choices))}")
    new = _NO if empty else _fit_current(value, current, hint, path, typed)
    if new is _NO:
        new = _fit_hint(value, hint, path)
    if new is _NO and empty and not _says_plainly(hint):
        new = value
    if new is _NO:
        expected = type(current).__name__ if not is_function_like(current) else "'module:name'"
        if empty:
            expected = " or ".join(option.__name__ for option in _alternatives(hint) if option is not type(None))
        raise ConfigError(f"{path}: expected {expected}, got {type(value).__name__} {value!r}")
    return copy.deepcopy(new) if isinstance(new, (list, tuple, dict, set)) and new is value else new


def _fit_current(value: Any, current: Any, hint: Any, path: str, typed: bool) -> Any:
    """``value`` converted to the kind of ``current``, or ``_NO``."""
    if isinstance(current, bool) or isinstance(value, (bool, np.bool_)):
        return bool(value) if isinstance(current, bool) and isinstance(value, (bool, np.bool_)) else _NO
    if isinstance(current, float):
        return float(value) if isinstance(value, _REAL) else _NO
    if isinstance(current, int) and not isinstance(current, enum.Enum):
        if not isinstance(value, _REAL):
            return _NO
        if float(value).is_integer():
            return int(value)
        return _NO if typed else float(value)  # an entry of a plain dictionary has no declared type
    if is_function_like(current):
        return _callable(value, path)
    if isinstance(current, (list, tuple)):
        return _fit_sequence(value, current, hint, path)
    if isinstance(current, (set, frozenset)):
        return type(current)(value) if isinstance(value, (list, tuple, set, frozenset)) else _NO
    if isinstance(current, slice):
        return _slice(value, path)
    if isinstance(current, torch.Tensor):
        if not isinstance(value, (list, tuple, *_REAL, np.ndarray, torch.Tensor)):
            return _NO
        return torch.as_tensor(value, dtype=current.dtype, device=current.device)
    if isinstance(current, np.ndarray):
        return np.asarray(value, dtype=current.dtype) if isinstance(value, (list, tuple, np.ndarray)) else _NO
    if isinstance(current, (enum.Enum, PurePath)):
        return _fit_class(value, type(current), path)
    return value if isinstance(value, type(current)) else _NO


def _fit_sequence(value: Any, current: list | tuple, hint: Any, path: str) -> Any:
    """``value`` as a sequence like ``current``: tuples stay tuples, floats floats, and configurations are updated."""
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
        return _NO
    items = list(value)
    if any(isinstance(item, Mapping) for item in items):
        if not current:
            return _NO
        if len(items) != len(current):
            raise ConfigError(f"{path}: expected {len(current)} entries, got {len(items)}")
        new = []
        for index, (item, old) in enumerate(zip(items, current, strict=True)):
            if isinstance(item, Mapping) and _is_nested(old):
                update_class_from_dict(old, item, f"{path}[{index}]")
                new.append(old)
            else:
                new.append(_coerce(item, old, None, f"{path}[{index}]", typed=False))
    else:
        length = _fixed_length(hint)
        if length is not None and length == len(current) != len(items):
            raise ConfigError(f"{path}: expected {length} values, got {len(items)}: {value!r}")
        numeric = bool(current) and all(_is_number(old) for old in current)
        all_float = numeric and all(isinstance(old, float) for old in current)
        new = []
        for index, item in enumerate(items):
            old = current[min(index, len(current) - 1)] if current else None
            if numeric and item is not None and not _is_number(item):
                return _NO
            if all_float and isinstance(item, int):
                item = float(item)
            elif isinstance(old, (list, tuple)) and isinstance(item, (list, tuple)):
                item = _fit_sequence(item, old, None, f"{path}[{index}]")
            new.append(item)
    return tuple(new) if isinstance(current, tuple) or isinstance(value, tuple) else new


def _is_number(value: Any) -> bool:
    return isinstance(value, _REAL) and not isinstance(value, (bool, np.bool_))


def _callable(value: Any, path: str) -> Any:
    if callable(value):
        return value
    if not isinstance(value, str):
        return _NO
    try:
        return string_to_callable(value)
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from error


def _slice(value: Any, path: str) -> Any:
    if isinstance(value, slice):
        return value
    if not (isinstance(value, str) and value.startswith("slice(")):
        return _NO
    try:
        return string_to_slice(value)
    except ValueError as error:
        raise ConfigError(f"{path}: {error}") from error


##
# Annotations
##


@functools.cache
def field_hints(cls: type) -> dict[str, Any]:
    """Evaluated annotations of a class and its bases; names whose annotation cannot be evaluated are left out."""
    hints: dict[str, Any] = {}
    for base in reversed(cls.__mro__):
        for name, annotation in vars(base).get("__annotations__", {}).items():
            hint = resolve_hint(annotation, base)
            if hint is not None:
                hints[name] = hint
    return hints


def resolve_hint(annotation: Any, owner: type) -> Any:
    """An annotation as a type, evaluated in the class that wrote it; None where that is impossible.

    ``Annotated[Any, T]`` is ``T``: a type checker lets sub-classes narrow the field to their own type.
    """
    if isinstance(annotation, str):
        module = sys.modules.get(owner.__module__)
        try:
            annotation = eval(annotation, vars(module) if module else {}, dict(vars(owner)))
        except (NameError, AttributeError, TypeError, SyntaxError):
            return None
    if get_origin(annotation) is Annotated and annotation.__origin__ is Any:
        return annotation.__metadata__[0]
    return annotation


def _alternatives(hint: Any) -> tuple[Any, ...]:
    return get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)


def _says_plainly(hint: Any) -> bool:
    """Whether an annotation is made of plain types (and None) only, so that it decides what may replace a None."""
    options = [option for option in _alternatives(hint) if option is not type(None)]
    return bool(options) and all(option in (bool, int, float, str) for option in options)


def _literal_choices(hint: Any) -> tuple[Any, ...] | None:
    """The values that an annotation allows, if it is made of literals (and None) only."""
    options = [option for option in _alternatives(hint) if option is not type(None)]
    if options and all(get_origin(option) is Literal for option in options):
        return tuple(choice for option in options for choice in get_args(option))
    return None


def _fixed_length(hint: Any) -> int | None:
    """Length of the tuple that an annotation asks for, if it asks for one only."""
    options = [option for option in _alternatives(hint) if option is not type(None)]
    if len(options) == 1 and get_origin(options[0]) is tuple and Ellipsis not in get_args(options[0]):
        return len(get_args(options[0]))
    return None


def _fit_hint(value: Any, hint: Any, path: str) -> Any:
    """``value`` converted to an annotation's type, or ``_NO`` where it does not fit or nothing is known."""
    if hint is None:
        return _NO
    options = _alternatives(hint)
    for option in options:
        if type(value) is (get_origin(option) or option) and not get_args(option):
            return value
    for option in options:
        new = _fit_option(value, option, path)
        if new is not _NO:
            return new
    return _NO


def _fit_option(value: Any, option: Any, path: str) -> Any:
    if option is Any:
        return value
    origin, args = get_origin(option) or option, get_args(option)
    if origin is Literal:
        return value if value in args else _NO
    if origin is bool or isinstance(value, (bool, np.bool_)):
        return bool(value) if origin is bool and isinstance(value, (bool, np.bool_)) else _NO
    if origin is float:
        return float(value) if isinstance(value, _REAL) else _NO
    if origin is int:
        return int(value) if isinstance(value, _REAL) and float(value).is_integer() else _NO
    if origin in (tuple, list, set, frozenset):
        return _fit_collection(value, origin, args, path)
    if origin is dict:
        if not isinstance(value, Mapping):
            return _NO
        inner = args[1] if len(args) == 2 else Any
        new = {key: _fit_entry(entry, inner, f"{path}.{key}") for key, entry in value.items()}
        return _NO if any(entry is _NO for entry in new.values()) else new
    if origin in (Callable, typing.Callable, type, types.FunctionType):
        named = isinstance(value, str) and (":" in value or is_lambda_expression(value))
        return _callable(value, path) if named or callable(value) else _NO
    if origin is slice:
        return _slice(value, path)
    return _fit_class(value, origin, path) if isinstance(origin, type) else _NO


def _fit_collection(value: Any, origin: type, args: tuple[Any, ...], path: str) -> Any:
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
        return _NO
    items = list(value)
    if origin is tuple and args and Ellipsis not in args:
        if len(items) != len(args):
            return _NO
        inner = args
    else:
        inner = [args[0] if args else Any] * len(items)
    new = [_fit_entry(item, hint, f"{path}[{i}]") for i, (item, hint) in enumerate(zip(items, inner, strict=True))]
    return _NO if any(item is _NO for item in new) else origin(new)


def _fit_entry(value: Any, hint: Any, path: str) -> Any:
    """:func:`_fit_hint` for an entry of a collection, where anything fits an annotation that says nothing."""
    known = all(isinstance(option, type) or get_origin(option) for option in _alternatives(hint))
    return _fit_hint(value, hint, path) if known else value


def _fit_class(value: Any, cls: type, path: str) -> Any:
    if isinstance(value, cls):
        return value
    if dataclasses.is_dataclass(cls) and isinstance(value, Mapping):
        new = cls()
        update_class_from_dict(new, value, path)
        return new
    if issubclass(cls, PurePath) and isinstance(value, str):
        return cls(value)
    if issubclass(cls, enum.Enum):
        for member in cls:
            if value in (member.name, member.value):
                return member
        raise ConfigError(f"{path}: {value!r} is not a {cls.__name__}; {suggest(str(value), cls.__members__)}")
    return _NO
