"""Dictionaries: to and from configurations, between array libraries, merged, hashed, printed."""

from __future__ import annotations

import dataclasses
import enum
import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import MISSING
from pathlib import PurePath
from typing import Any

import torch

from .array import TENSOR_TYPE_CONVERSIONS, TENSOR_TYPES
from .config_update import MISSING_TEXT, update_class_from_dict
from .string import callable_to_string, is_function_like, string_to_callable, string_to_slice


def class_to_dict(obj: object) -> Any:
    """Convert a configuration, and all that it holds, into a nested dictionary.

    Callables become ``"module:name"`` (a lambda its source text), ``MISSING`` becomes ``"???"``, an enum member its
    name and a path its text. Lists and tuples keep their type; tensors, arrays and slices stay as they are.

    Args:
        obj: a configuration, dictionary, list or value.
    """
    if obj is MISSING:
        return MISSING_TEXT
    if isinstance(obj, dict):
        return {key: class_to_dict(value) for key, value in obj.items()}
    if isinstance(obj, (list, tuple)):
        values = [class_to_dict(value) for value in obj]
        return type(obj)(*values) if hasattr(obj, "_fields") else type(obj)(values)
    if is_function_like(obj):
        try:
            return callable_to_string(obj)  # type: ignore[arg-type]
        except ValueError:
            return obj
    if isinstance(obj, enum.Enum):
        return obj.name
    if isinstance(obj, PurePath):
        return str(obj)
    if isinstance(obj, torch.Tensor):
        return obj
    if dataclasses.is_dataclass(obj) or (hasattr(obj, "__dict__") and not callable(obj)):
        return {key: class_to_dict(value) for key, value in vars(obj).items() if not key.startswith("__")}
    return obj


def dict_to_md5_hash(data: object) -> str:
    """MD5 digest (hexadecimal) of a dictionary or configuration, independent of the order of its keys."""
    plain = data if isinstance(data, dict) else class_to_dict(data)
    return hashlib.md5(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def convert_dict_to_backend(
    data: dict, backend: str = "numpy", array_types: Iterable[str] = ("numpy", "torch")
) -> dict:
    """Convert the arrays of a nested dictionary to another library.

    Args:
        data: nested dictionary. Values that are no arrays are passed on as they are.
        backend: "numpy" or "torch".
        array_types: the libraries whose arrays are converted.

    Raises:
        ValueError: unknown library.
    """
    for name in (backend, *array_types):
        if name not in TENSOR_TYPES:
            raise ValueError(f"unknown array library {name!r}; choose one of {sorted(TENSOR_TYPES)}")
    sources = {TENSOR_TYPES[name] for name in array_types if name != backend}
    conversions = TENSOR_TYPE_CONVERSIONS[backend]
    converted = {}
    for key, value in data.items():
        if type(value) in sources:
            converted[key] = conversions[type(value)](value)
        elif isinstance(value, dict):
            converted[key] = convert_dict_to_backend(value, backend, array_types)
        else:
            converted[key] = value
    return converted


def update_dict(orig_dict: dict, new_dict: Mapping) -> dict:
    """Merge ``new_dict`` into ``orig_dict`` in place, level by level, and return it."""
    for key, value in new_dict.items():
        if isinstance(value, Mapping):
            below = orig_dict.get(key)
            orig_dict[key] = update_dict(below if isinstance(below, dict) else {}, value)
        else:
            orig_dict[key] = value
    return orig_dict


def replace_slices_with_strings(data: Any) -> Any:
    """Replace slices in nested dictionaries, lists and tuples by ``"slice(start,stop,step)"``."""
    if isinstance(data, slice):
        return f"slice({data.start},{data.stop},{data.step})"
    return _map_entries(replace_slices_with_strings, data)


def replace_strings_with_slices(data: Any) -> Any:
    """Undo :func:`replace_slices_with_strings`."""
    if isinstance(data, str) and data.startswith("slice("):
        return string_to_slice(data)
    return _map_entries(replace_strings_with_slices, data)


def _map_entries(function, data: Any) -> Any:
    if isinstance(data, dict):
        return {key: function(value) for key, value in data.items()}
    if type(data) in (list, tuple):
        return type(data)(function(value) for value in data)
    return data


def print_dict(val: Any, nesting: int = -4, start: bool = True) -> None:
    """Print a nested dictionary, four spaces a level; callables by name."""
    if isinstance(val, dict):
        if not start:
            print()
        for key, value in val.items():
            print(f"{' ' * (nesting + 4)}{key}: ", end="")
            print_dict(value, nesting + 4, start=False)
    else:
        print(class_to_dict(val))


__all__ = [
    "callable_to_string",
    "class_to_dict",
    "convert_dict_to_backend",
    "dict_to_md5_hash",
    "print_dict",
    "replace_slices_with_strings",
    "replace_strings_with_slices",
    "string_to_callable",
    "update_class_from_dict",
    "update_dict",
]
