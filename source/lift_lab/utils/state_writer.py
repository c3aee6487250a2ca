"""Write the state of objects down as a tree of tensors and plain values.

Numbers, text, None and tensors stand for themselves. Every other value is a *node*: a tuple that begins with its kind.
A tree holds nothing but what :func:`torch.load` reads without running code. :mod:`.state_reader` reads it.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import random
import sys
import types
from collections import Counter, OrderedDict, deque
from collections.abc import Callable, Mapping, Set
from typing import Any

import numpy as np
import torch

from .saved_state import Stateful, Stateless, attributes_of

PLAIN = (type(None), bool, int, float, complex, str, bytes)
DICTS: dict[str, type] = {"dict": dict, "OrderedDict": OrderedDict, "Counter": Counter}
SEQUENCES: dict[str, type] = {"list": list, "deque": deque, "set": set, "frozenset": frozenset, "tuple": tuple}

_CODE = (
    *(types.FunctionType, types.BuiltinFunctionType, types.MethodType, types.MethodWrapperType, types.ModuleType),
    *(type, functools.partial, property, slice, range, torch.dtype, torch.device, torch.Size),
)
"""Types of code, and of values that never change."""

_FIXED = frozenset(
    {"mujoco", "mujoco_warp", "warp", "gymnasium", "pxr", "viser", "trimesh", "rich", "omegaconf", "hydra", "logging"}
    | {
        "abc",
        "pathlib",
        "re",
        "datetime",
        "decimal",
        "fractions",
        "inspect",
        "typing",
        "threading",
        "_thread",
        "weakref",
    }
)
"""Packages whose objects never change, or are restored by others."""

GENERATORS: dict[str, tuple[type, Callable[[Any], Any], Callable[[Any, Any], Any]]] = {
    "torch": (torch.Generator, lambda g: g.get_state(), lambda g, state: g.set_state(state)),
    "numpy": (
        np.random.Generator,
        lambda g: g.bit_generator.state,
        lambda g, state: setattr(g.bit_generator, "state", state),
    ),
    "numpy_old": (np.random.RandomState, lambda g: g.get_state(legacy=False), lambda g, state: g.set_state(state)),
    "python": (random.Random, lambda g: g.getstate(), lambda g, state: g.setstate(state)),
}
"""Generators of random numbers: type, reading and writing the state."""


def _is_config(value: Any) -> bool:
    return dataclasses.is_dataclass(value) and callable(getattr(type(value), "validate", None))


def has_attributes(value: Any) -> bool:
    """Whether the attributes of an object are its state: of this project's classes, or of a task's author."""
    if isinstance(value, (Stateful, types.SimpleNamespace)):
        return True
    module = type(value).__module__
    root = module.partition(".")[0]
    if root in ("torch", "tensordict"):
        return module.startswith("torch.distributions")
    if root in _FIXED or root == "numpy" or root in sys.stdlib_module_names:
        return False
    return hasattr(value, "__dict__") or hasattr(type(value), "__slots__")


def saves_itself(value: Any) -> bool:
    """Whether an object has methods of its own by which it saves itself."""
    own = getattr(type(value), "state_dict", None)
    return callable(own) and own is not Stateful.state_dict and callable(getattr(value, "load_state_dict", None))


def is_no_state(value: Any) -> bool:
    """Whether nothing is lost if a value is not saved."""
    if isinstance(value, (Stateless, *_CODE)) or _is_config(value):
        return True
    return type(value).__module__.partition(".")[0] in _FIXED and not isinstance(value, tuple)


def parts_of(value: Any) -> dict[str, Any]:
    parts = value.state_parts() if isinstance(value, Stateful) else attributes_of(value)
    return {name: part for name, part in parts.items() if not is_no_state(part)}


def _is_key(key: Any) -> bool:
    return type(key) in PLAIN or (type(key) is tuple and all(map(_is_key, key)))


def is_data(node: Any) -> bool:
    """Whether a node alone is enough to make its value."""
    if not isinstance(node, tuple):
        return True
    kind, *rest = node
    if kind in SEQUENCES:
        return all(map(is_data, rest[-1]))
    if kind == "dict":
        return rest[0] in DICTS and all(_is_key(key) and is_data(entry) for key, entry in rest[1])
    return kind in ("array", "scalar", "generator", "on")


class StateWriter:
    """Writes objects down.

    Tensors are copied with their memory: those that share it here share it in the copy. An object, list or dictionary
    that is met a second time is a reference to the first.

    Attributes:
        unsaved: path and type of every value that could not be written down.
    """

    def __init__(
        self,
        device: str | torch.device = "cpu",
        engine: Set[int] = frozenset(),
        known: Mapping[int, str] | None = None,
    ):
        """Prepare.

        Args:
            device: where most tensors are.
            engine: addresses of memory that the physics engine restores.
            known: path of objects by their id: met anywhere else, they are references to it.
        """
        self.unsaved: list[str] = []
        self._device = torch.device(device)
        self._engine = engine
        self._paths = dict(known or {})
        self._alive: list[Any] = []  # so that an id is not given twice
        self._storages: dict[int, torch.UntypedStorage] = {}
        self._tensors: dict[int, Any] = {}

    def parts(self, value: Any, path: str) -> dict[str, Any]:
        """The parts of an object's state as nodes.

        Args:
            value: the object.
            path: where it is, for references and messages.
        """
        prefix = f"{path}." if path else ""
        return {name: self.node(part, f"{prefix}{name}") for name, part in parts_of(value).items()}

    def object(self, value: Any, path: str) -> tuple:
        """An object as a node of its parts."""
        version = value.state_version if isinstance(value, Stateful) else 1
        return ("object", type(value).__qualname__, version, self.parts(value, path))

    def own(self, value: Any, path: str) -> tuple:
        """An object that saves itself as a node."""
        return ("own", type(value).__qualname__, self.node(value.state_dict(), path))

    def node(self, value: Any, path: str) -> Any:
        """A value as a node."""
        if type(value) in PLAIN:
            return value
        if isinstance(value, torch.Tensor):
            return self._tensor(value, path)
        met = self._paths.get(id(value), path)
        if met != path:
            return ("same", met)
        if is_no_state(value):
            return ("kept",)
        if isinstance(value, enum.Enum):
            return ("enum", type(value).__qualname__, value.name)
        if isinstance(value, np.generic) and not value.dtype.hasobject:
            return ("scalar", *_array_node(np.asarray(value))[1:])
        if not isinstance(value, (tuple, frozenset)):  # those may be one object by chance
            self._paths[id(value)] = path
        self._alive.append(value)
        return self._below(value, path)

    def _below(self, value: Any, path: str) -> Any:
        for kind, cls in SEQUENCES.items():
            if isinstance(value, cls):
                if kind in ("set", "frozenset"):
                    return (kind, list(value)) if all(map(_is_key, value)) else self._lost(value, path)
                items = [self.node(item, f"{path}[{k}]") for k, item in enumerate(value)]
                return (kind, value.maxlen, items) if kind == "deque" else (kind, items)
        if isinstance(value, dict):
            if not all(map(_is_key, value)):
                return self._lost(value, path)
            entries = [(key, self.node(entry, f"{path}[{key!r}]")) for key, entry in value.items()]
            kind = next((name for name, cls in DICTS.items() if type(value) is cls), type(value).__qualname__)
            return ("dict", kind, entries)
        if isinstance(value, np.ndarray) and not value.dtype.hasobject:
            return _array_node(value)
        for kind, (cls, read, _) in GENERATORS.items():
            if isinstance(value, cls):
                where = str(value.device) if isinstance(value, torch.Generator) else ""
                return ("generator", kind, where, self.node(read(value), path))
        if saves_itself(value):
            return self.own(value, path)
        return self.object(value, path) if has_attributes(value) else self._lost(value, path)

    def _lost(self, value: Any, path: str) -> tuple:
        self.unsaved.append(f"{path} ({type(value).__module__}.{type(value).__qualname__})")
        return ("kept",)

    def _tensor(self, value: torch.Tensor, path: str) -> Any:
        if id(value) in self._tensors:
            return self._tensors[id(value)]
        if value.layout != torch.strided or value.is_quantized:
            return self._lost(value, path)
        storage = value.untyped_storage()
        address = storage.data_ptr()
        if address in self._engine and value.numel():
            return ("engine",)
        if not address:
            copy: Any = torch.empty_like(value.detach(), device="cpu")
        else:
            if address not in self._storages:
                self._storages[address] = bytes_of(storage).to("cpu", copy=True).untyped_storage()
            copy = view_of(self._storages[address], value, "cpu")
        if value.device.type != self._device.type:
            copy = ("on", str(value.device), copy)
        self._alive.append(value)
        self._tensors[id(value)] = copy
        return copy


# -- leaves


def _array_node(value: np.ndarray) -> tuple:
    data = torch.frombuffer(bytearray(np.ascontiguousarray(value).tobytes() or b"\0"), dtype=torch.uint8)
    return ("array", np.lib.format.dtype_to_descr(value.dtype), list(value.shape), data)


def bytes_of(storage: torch.UntypedStorage) -> torch.Tensor:
    """A storage as a tensor of bytes on the same memory."""
    with torch.inference_mode(False):
        return torch.empty(0, dtype=torch.uint8, device=storage.device).set_(storage)


def view_of(storage: torch.UntypedStorage, like: torch.Tensor, device: Any) -> torch.Tensor:
    """A tensor on a storage with type, shape and place in memory of another one."""
    with torch.inference_mode(False):
        empty = torch.empty(0, dtype=like.dtype, device=device)
        return empty.set_(storage, like.storage_offset(), like.shape, like.stride())
