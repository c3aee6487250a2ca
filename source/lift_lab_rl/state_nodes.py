"""Kinds of values in a saved state, and how each is written as tensors and plain values.

A value is written as a *node*. Numbers, text, None and tensors stand for themselves; every other node is a tuple whose
first entry is its kind. Nodes hold nothing but what :func:`torch.load` reads without running code.
"""

from __future__ import annotations

import enum
import functools
import random
import sys
import types
from collections import Counter, OrderedDict, deque
from typing import Any

import gymnasium as gym
import numpy as np
import torch
from gymnasium.envs.registration import EnvSpec

PLAIN = (type(None), bool, int, float, complex, str, bytes)
"""Types whose values stand for themselves."""

DICT_TYPES: dict[str, type] = {"dict": dict, "OrderedDict": OrderedDict, "Counter": Counter}
"""Dictionaries that can be made again from their entries alone."""

_FIXED_MODULES = frozenset(
    {"mujoco", "mujoco_warp", "warp", "rich", "pxr", "viser", "trimesh", "numpy", "omegaconf", "hydra"}
    | {"abc", "contextlib", "datetime", "decimal", "enum", "fractions", "inspect", "logging", "pathlib", "re"}
    | {"threading", "_thread", "concurrent", "types", "typing", "uuid", "weakref", "_weakref", "builtins"}
)
"""Top-level modules whose objects never change, or are restored or made by others."""

_FIXED_TYPES = (
    *(torch.dtype, torch.device, torch.layout, torch.memory_format, torch.Size, slice, range, property),
    *(gym.Space, EnvSpec),
)
"""Types whose values never change."""

_NAMED = (
    *(types.FunctionType, types.BuiltinFunctionType, types.MethodType, type),
    *(types.MethodWrapperType, types.WrapperDescriptorType, types.MethodDescriptorType),
)
"""Types of functions, and of types."""

_MUTABLE = (np.ndarray, bytearray, memoryview, types.GeneratorType, types.CoroutineType)
"""Types whose values change, of modules whose other objects do not."""


def is_plain(value: Any) -> bool:
    """Whether a value stands for itself."""
    return type(value) in PLAIN


def is_data(node: Any) -> bool:
    """Whether a node alone is enough to make its value again: it needs no object that is already there."""
    if not isinstance(node, tuple):
        return True
    kind, *rest = node
    if kind in ("list", "tuple"):
        return all(map(is_data, rest[-1]))
    if kind == "deque":
        return all(map(is_data, rest[1]))
    if kind == "dict":
        return rest[0] in DICT_TYPES and all(is_key(key) and is_data(entry) for key, entry in rest[1])
    return kind in ("set", "frozenset", "array", "scalar", "generator", "elsewhere")


def is_key(key: Any) -> bool:
    """Whether a key of a dictionary, or an item of a set, can be written down as it is."""
    return is_plain(key) or (type(key) is tuple and all(map(is_key, key)))


def name_of(value: Any) -> str | None:
    """Name of a function, method, class or module; None for other values."""
    if isinstance(value, functools.partial):
        return name_of(value.func)
    if isinstance(value, types.ModuleType):
        return value.__name__
    if isinstance(value, _NAMED):
        return f"{getattr(value, '__module__', '')}.{getattr(value, '__qualname__', type(value).__name__)}"
    return None


def is_object(value: Any) -> bool:
    """Whether the attributes of a value are its state: of this project's classes, of a task's author, or a network."""
    if isinstance(value, (torch.jit.ScriptModule, *_FIXED_TYPES)):
        return False
    if isinstance(value, (torch.nn.Module, types.SimpleNamespace)):
        return True
    root = type(value).__module__.partition(".")[0]
    if root in ("torch", "tensordict"):
        return type(value).__module__.startswith("torch.distributions")
    if root in _FIXED_MODULES or root in sys.stdlib_module_names:
        return False
    return hasattr(value, "__dict__") or any("__slots__" in vars(cls) for cls in type(value).__mro__)


def saves_itself(value: Any) -> bool:
    """Whether an object has the two methods by which it saves itself."""
    if isinstance(value, torch.nn.Module) and not isinstance(value, torch.jit.ScriptModule):
        return False
    return callable(getattr(value, "state_dict", None)) and callable(getattr(value, "load_state_dict", None))


def never_changes(value: Any) -> bool:
    """Whether nothing is lost if a value is not saved."""
    if isinstance(value, _FIXED_TYPES):
        return True
    return type(value).__module__.partition(".")[0] in _FIXED_MODULES and not isinstance(value, _MUTABLE)


def attributes_of(value: Any) -> dict[str, Any]:
    """Attributes of an object: those in its dictionary and those in slots."""
    found = {}
    for cls in reversed(type(value).__mro__):
        slots = vars(cls).get("__slots__", ())
        for slot in (slots,) if isinstance(slots, str) else slots:
            name = f"_{cls.__name__.lstrip('_')}{slot}" if slot.startswith("__") and not slot.endswith("__") else slot
            if name not in ("__dict__", "__weakref__") and hasattr(value, name):
                found[name] = getattr(value, name)
    return found | dict(getattr(value, "__dict__", {}))


# -- leaves


def array_node(value: np.ndarray) -> tuple | None:
    """An array as a node; None for one of objects."""
    if value.dtype.hasobject:
        return None
    data = torch.frombuffer(bytearray(np.ascontiguousarray(value).tobytes() or b"\0"), dtype=torch.uint8)
    return ("array", np.lib.format.dtype_to_descr(value.dtype), list(value.shape), data)


def array_of(node: tuple) -> np.ndarray:
    """The array of a node."""
    _, descr, shape, data = node
    dtype = np.lib.format.descr_to_dtype(descr)
    count = int(np.prod(shape, dtype=np.int64))
    return np.frombuffer(data.numpy().tobytes()[: count * dtype.itemsize], dtype).reshape(shape).copy()


def generator_node(value: Any) -> tuple | None:
    """The state of a generator of random numbers as a node; None for another value."""
    if isinstance(value, torch.Generator):
        return ("generator", f"torch {value.device}", value.get_state())
    if isinstance(value, (np.random.Generator, np.random.RandomState)):
        bits: Any = value.bit_generator if isinstance(value, np.random.Generator) else value._bit_generator
        return ("generator", f"numpy {type(value).__name__}", _numpy_state(bits.state))
    if isinstance(value, random.Random):
        version, numbers, gauss = value.getstate()
        return ("generator", "random", [version, list(numbers), gauss])
    return None


def _numpy_state(state: Any) -> Any:
    """The state of numpy's bit generators, with arrays as nodes."""
    if isinstance(state, dict):
        return {key: _numpy_state(entry) for key, entry in state.items()}
    return array_node(state) if isinstance(state, np.ndarray) else state


def _from_numpy_state(state: Any) -> Any:
    if isinstance(state, dict):
        return {key: _from_numpy_state(entry) for key, entry in state.items()}
    return array_of(state) if isinstance(state, tuple) else state


def set_generator(value: Any, node: tuple) -> None:
    """Write a state of :func:`generator_node` into a generator of the same kind."""
    state = node[2]
    if isinstance(value, torch.Generator):
        value.set_state(state)
    elif isinstance(value, random.Random):
        value.setstate((state[0], tuple(state[1]), state[2]))
    else:
        bits = value.bit_generator if isinstance(value, np.random.Generator) else value._bit_generator
        bits.state = _from_numpy_state(state)


def new_generator(node: tuple) -> Any:
    """A generator with the state of a node."""
    kind, state = node[1], node[2]
    if kind.startswith("torch "):
        made: Any = torch.Generator(device=kind.removeprefix("torch "))
    elif kind == "random":
        made = random.Random()
    else:
        bits = getattr(np.random, state["bit_generator"])()
        made = np.random.Generator(bits) if kind == "numpy Generator" else np.random.RandomState(bits)
    set_generator(made, node)
    return made


def leaf_node(value: Any) -> Any:
    """The node of an array, a number of numpy's, an enum member, a generator or a function; None for other values."""
    if isinstance(value, np.ndarray):
        return array_node(value)
    if isinstance(value, np.generic) and not value.dtype.hasobject:
        return ("scalar", array_node(np.asarray(value)))
    if isinstance(value, enum.Enum):
        return ("enum", f"{type(value).__module__}.{type(value).__qualname__}", value.name)
    node = generator_node(value)
    if node is not None:
        return node
    name = name_of(value)
    return None if name is None else ("name", name)


def dict_type(value: dict) -> str:
    """The kind of a dictionary."""
    return next((name for name, kind in DICT_TYPES.items() if type(value) is kind), type(value).__qualname__)


def sequence_kind(value: Any) -> str | None:
    """ "list", "deque", "set", "frozenset" or "tuple"; None for other values."""
    kinds = {list: "list", deque: "deque", set: "set", frozenset: "frozenset", tuple: "tuple"}
    return next((name for cls, name in kinds.items() if isinstance(value, cls)), None)
