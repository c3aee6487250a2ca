"""Put a graph of objects into a state that :mod:`.state_capture` wrote down.

First everything is compared and planned, then it is written: a state of something else is refused before anything has
changed. Tensors and containers are written in place wherever that gives the same structure, because other parts of the
program may hold them, too.
"""

from __future__ import annotations

import dataclasses
import enum
from collections import deque
from collections.abc import Callable, Set
from typing import Any

import numpy as np
import torch

from lift_lab.utils.errors import StateMismatchError
from lift_lab.utils.saved_state import copy_into, unsaved_attributes

from .state_capture import Capture, bytes_of, view_of
from .state_nodes import (
    DICT_TYPES,
    array_of,
    attributes_of,
    generator_node,
    is_data,
    is_object,
    is_plain,
    leaf_node,
    name_of,
    never_changes,
    new_generator,
    saves_itself,
    sequence_kind,
    set_generator,
)

_KINDS = frozenset(
    {
        *("list", "deque", "set", "frozenset", "tuple", "dict", "object", "state_dict"),
        *("array", "scalar", "enum", "name", "generator", "engine", "fixed", "elsewhere"),
    }
)
"""Kinds of nodes that have a method of their own."""


class _Absent:
    """Stands for what is not there."""


_ABSENT = _Absent()


class Restore:
    """Plans how objects get their saved values, then does it."""

    def __init__(self, engine_storages: Set[int], is_left_out: Callable[[Any], bool], device: str | torch.device):
        """Prepare a plan.

        Args:
            engine_storages: addresses of memory that the physics engine restores.
            is_left_out: whether an object is no part of the state.
            device: where new tensors are made.
        """
        self._device = device
        self._engine_storages = engine_storages
        self._is_left_out = is_left_out
        self._actions: list[Callable[[], Any]] = []
        self._finals: dict[str, Any] = {}  # path -> the container or object that will be there
        self._taken: set[int] = set()  # ids of live values that already have their place
        self._tensors: dict[int, torch.Tensor] = {}  # id of a saved tensor -> the one that takes its values
        self._live_of_saved: dict[int, torch.UntypedStorage] = {}
        self._saved_of_live: dict[int, int] = {}
        self._kept: list[Any] = []  # so that an id is not given twice

    def plan(self, root: Any, node: Any, path: str = "") -> None:
        """Compare the objects with a state.

        Args:
            root: the object at the root.
            node: its node.
            path: what paths begin with.

        Raises:
            StateMismatchError: the state is of something else; names the first thing that differs.
        """
        try:
            self._value(root, node, path)
        except StateMismatchError:
            raise
        except Exception as error:  # of a state that is no state, anything can be wrong
            raise StateMismatchError(f"the saved state is not valid: {' '.join(str(error).split())[:120]}") from error

    def apply(self) -> None:
        """Write the values, then tell the objects."""
        with torch.no_grad():
            for action in self._actions:
                action()
        for value in list(self._finals.values()):
            loaded = getattr(type(value), "on_state_loaded", None)
            if loaded is not None:
                loaded(value)

    # -- one value

    def _value(self, live: Any, node: Any, path: str) -> Any:
        """What will be in a place; ``live`` itself, if it only has to be written into."""
        self._check_class(live, node, path)
        if isinstance(node, torch.Tensor):
            return self._tensor(live, node)
        if is_plain(node):
            return self._plain(live, node)
        kind = node[0]
        if kind == "same":
            return self._finals[node[1]]
        if kind not in _KINDS:
            raise ValueError(f"'{path}' is of an unknown kind")
        final = getattr(self, f"_{kind}")(live, node, path)
        self._finals[path] = final
        self._kept.append(final)
        return final

    def _check_class(self, live: Any, node: Any, path: str) -> None:
        """Numbers (also in tensors), text and containers do not become one another while an environment runs."""
        if live is _ABSENT or node == ("fixed",):
            return
        ours, theirs = _class_of_value(live), _class_of_node(node)
        if None not in (ours, theirs) and ours != theirs:
            raise self._mismatch(path, f"is of type {type(live).__name__}, it was {theirs}")

    def _plain(self, live: Any, node: Any) -> Any:
        if is_plain(live):
            return live if type(live) is type(node) and repr(live) == repr(node) else node  # also NaN and -0.0
        return live if live is not _ABSENT and self._stays(live) else node

    def _stays(self, live: Any) -> bool:
        """Whether a live value is no part of the state."""
        if is_plain(live) or isinstance(live, (torch.Tensor, dict)) or sequence_kind(live) is not None:
            return False
        return self._is_left_out(live) or (leaf_node(live) is None and not is_object(live) and never_changes(live))

    def _fixed(self, live: Any, node: Any, path: str) -> Any:
        if live is _ABSENT:
            raise self._mismatch(path, "is not there")
        return live

    def _mismatch(self, path: str, problem: str) -> StateMismatchError:
        return StateMismatchError(f"the saved state is of another environment: '{path}' {problem}")

    def _free(self, live: Any) -> bool:
        """Whether a live container or object has no place yet; it has one now."""
        if id(live) in self._taken:
            return False
        self._taken.add(id(live))
        self._kept.append(live)
        return True

    def _made(self, node: Any, path: str, live: Any = _ABSENT) -> Any:
        """A new value from a node alone."""
        if not is_data(node):
            raise self._mismatch(path, _was(node, live))
        kind, *rest = node
        if kind == "dict":
            made: Any = DICT_TYPES[rest[0]]()
            for key, entry in rest[1]:
                made[key] = self._value(_ABSENT, entry, f"{path}[{key!r}]")
            return made
        items = [self._value(_ABSENT, entry, f"{path}[{k}]") for k, entry in enumerate(rest[-1])]
        if kind == "deque":
            return deque(items, rest[0])
        return {"list": list, "tuple": tuple, "set": set, "frozenset": frozenset}[kind](items)

    # -- containers

    def _list(self, live: Any, node: Any, path: str) -> Any:
        if sequence_kind(live) != node[0] or not self._free(live):
            return self._made(node, path, live)
        items, before = node[-1], list(live)
        for k, entry in enumerate(before[len(items) :], len(items)):
            self._check_may_go(entry, f"{path}[{k}]")
        finals = [
            self._value(before[k] if k < len(before) else _ABSENT, entry, f"{path}[{k}]")
            for k, entry in enumerate(items)
        ]
        if len(before) != len(finals) or any(a is not b for a, b in zip(before, finals, strict=True)):
            self._actions.append(lambda: (live.clear(), live.extend(finals)))
        return live

    _deque = _list

    def _tuple(self, live: Any, node: Any, path: str) -> Any:
        items = node[1]
        if not isinstance(live, tuple) or len(live) != len(items):
            return self._made(node, path, live)
        pairs = enumerate(zip(live, items, strict=True))
        finals = [self._value(entry, item, f"{path}[{k}]") for k, (entry, item) in pairs]
        if all(a is b for a, b in zip(live, finals, strict=True)):
            return live
        return type(live)(*finals) if hasattr(live, "_fields") else type(live)(finals)

    def _set(self, live: Any, node: Any, path: str) -> Any:
        if not isinstance(live, set) or not self._free(live):
            return self._made(node, path, live)
        if live != set(node[1]):
            self._actions.append(lambda: (live.clear(), live.update(node[1])))
        return live

    def _frozenset(self, live: Any, node: Any, path: str) -> Any:
        return live if isinstance(live, frozenset) and live == frozenset(node[1]) else frozenset(node[1])

    def _dict(self, live: Any, node: Any, path: str) -> Any:
        if not isinstance(live, dict) or not self._free(live):
            return self._made(node, path, live)
        before = list(live)
        keys = [before[key[1]] if _is_numbered(key) else key for key, _ in node[2]]
        for key in before:
            if key not in keys:
                self._check_may_go(live[key], f"{path}[{key!r}]")
        finals = {
            key: self._value(live.get(key, _ABSENT) if key in before else _ABSENT, entry, f"{path}[{key!r}]")
            for key, (_, entry) in zip(keys, node[2], strict=True)
        }
        if before != keys or any(live[key] is not final for key, final in finals.items()):

            def fill() -> None:
                live.clear()
                for key, final in finals.items():
                    live[key] = final

            self._actions.append(fill)
        return live

    def _check_may_go(self, live: Any, path: str) -> None:
        """What the saved state does not have can be removed if it is data."""
        if not is_data(Capture(self._engine_storages, self._is_left_out).node(live, path)):
            raise self._mismatch(path, "is not in it")

    # -- objects

    def _object(self, live: Any, node: Any, path: str) -> Any:
        if not is_object(live) or type(live).__qualname__ != node[1] or not self._free(live):
            raise self._mismatch(path, _was(node, live))
        self._finals[path] = live
        here, left_out = attributes_of(live), unsaved_attributes(live)
        # a setting that is newer than the saved state has its default value, or the configurations would differ
        new = () if dataclasses.is_dataclass(live) else here.keys() - node[2].keys() - left_out
        for name in sorted(new):
            if not self._stays(here[name]) and name_of(here[name]) is None:
                raise self._mismatch(f"{path}.{name}" if path else name, "is not in it")
        for name, entry in node[2].items():
            if name in left_out:
                continue
            before = here.get(name, _ABSENT)
            final = self._value(before, entry, f"{path}.{name}" if path else name)
            if final is None and before is not None and dataclasses.is_dataclass(live):
                self._check_may_go(before, f"{path}.{name}")
            if final is not before:
                self._actions.append(lambda name=name, final=final: object.__setattr__(live, name, final))
        return live

    def _state_dict(self, live: Any, node: Any, path: str) -> Any:
        if not saves_itself(live) or type(live).__qualname__ != node[1]:
            raise self._mismatch(path, _was(node, live))
        content = self._value(_ABSENT, node[2], f"{path}.state_dict()")

        def load() -> None:
            try:
                live.load_state_dict(content)
            except Exception as error:  # of the class of somebody else
                raise StateMismatchError(f"'{path}' does not take its saved state: {error}") from error

        self._actions.append(load)
        return live

    # -- leaves

    def _array(self, live: Any, node: Any, path: str) -> Any:
        values = array_of(node)
        if not isinstance(live, np.ndarray) or (live.shape, live.dtype) != (values.shape, values.dtype):
            return values
        if not self._free(live):
            return values
        if live.tobytes() != values.tobytes():
            if not live.flags.writeable:
                raise StateMismatchError(f"'{path}' is an array that cannot be written to")
            self._actions.append(lambda: np.copyto(live, values))
        return live

    def _scalar(self, live: Any, node: Any, path: str) -> Any:
        value = array_of(node[1])[()]
        same = isinstance(live, np.generic) and live.dtype == value.dtype and live.tobytes() == value.tobytes()
        return live if same else value

    def _enum(self, live: Any, node: Any, path: str) -> Any:
        members: Any = type(live)
        found = leaf_node(live)
        if not isinstance(found, tuple) or found[:2] != node[:2]:
            raise self._mismatch(path, _was(node, live))
        return live if live.name == node[2] else members[node[2]]

    def _name(self, live: Any, node: Any, path: str) -> Any:
        if len(node) == 3:  # a method of an object
            before = getattr(live, "__self__", _ABSENT)
            owner = self._value(before, node[2], f"{path}.__self__")
            if name_of(live) == node[1] and owner is before:
                return live
            return getattr(owner, node[1].rpartition(".")[2])
        if name_of(live) != node[1]:
            raise self._mismatch(path, f"is {name_of(live) or type(live).__qualname__}, it was {node[1]}")
        return live

    def _generator(self, live: Any, node: Any, path: str) -> Any:
        found = generator_node(live)
        if found is None or found[1] != node[1] or not self._free(live):
            return new_generator(node)
        new_generator(node)  # a state that is no state is noticed here
        self._actions.append(lambda: set_generator(live, node))
        return live

    # -- tensors

    def _engine(self, live: Any, node: Any, path: str) -> Any:
        ours = isinstance(live, torch.Tensor) and live.untyped_storage().data_ptr() in self._engine_storages
        if not ours or list(live.shape) != node[1]:
            raise self._mismatch(path, f"was a tensor of the physics engine of shape {tuple(node[1])}")
        return live

    def _elsewhere(self, live: Any, node: Any, path: str) -> Any:
        return self._tensor(live, node[2], node[1])

    def _tensor(self, live: Any, saved: torch.Tensor, device: str | None = None) -> torch.Tensor:
        known = self._tensors.get(id(saved))
        if known is None:
            known = self._tensors[id(saved)] = self._target(live, saved, device)
            self._kept.append(saved)
        return known

    def _target(self, live: Any, saved: torch.Tensor, device: torch.device | str | None) -> torch.Tensor:
        """The tensor that takes a saved one's values: the live one where it lies in memory as the saved one does."""
        source = saved.untyped_storage()
        address = source.data_ptr()
        if self._lies_alike(live, saved) and self._free(live):
            mine = live.untyped_storage()
            if address:
                self._live_of_saved[address] = mine
                self._saved_of_live[mine.data_ptr()] = address
            if not _same_bytes(live, saved):
                self._actions.append(lambda: copy_into(live, saved))
            return live
        if device is None:
            device = live.device if isinstance(live, torch.Tensor) else self._device
        if not address:
            return torch.empty_like(saved, device=device)
        if address not in self._live_of_saved:
            with torch.inference_mode(False):
                self._live_of_saved[address] = bytes_of(source).to(device, copy=True).untyped_storage()
        made = view_of(self._live_of_saved[address], saved, self._live_of_saved[address].device)
        self._actions.append(lambda: copy_into(made, saved))
        return made

    def _lies_alike(self, live: Any, saved: torch.Tensor) -> bool:
        if not isinstance(live, torch.Tensor) or live.layout != torch.strided:
            return False
        mine, source = live.untyped_storage(), saved.untyped_storage()
        if mine.data_ptr() in self._engine_storages and live.numel():
            return False
        if (live.shape, live.dtype, live.stride()) != (saved.shape, saved.dtype, saved.stride()):
            return False
        if not source.data_ptr() or not mine.data_ptr():
            return source.data_ptr() == mine.data_ptr()
        known = self._live_of_saved.get(source.data_ptr())
        return (
            live.storage_offset() == saved.storage_offset()
            and mine.nbytes() == source.nbytes()
            and (known is None or known.data_ptr() == mine.data_ptr())
            and self._saved_of_live.get(mine.data_ptr(), source.data_ptr()) == source.data_ptr()
        )


def _same_bytes(a: torch.Tensor, b: torch.Tensor) -> bool:
    if torch.equal(a, b.to(a.device)):
        # 0.0 equals -0.0
        return not a.is_floating_point() or torch.equal(torch.signbit(a), torch.signbit(b.to(a.device)))
    return False


_CLASSES = {
    **dict.fromkeys(("array", "scalar", "engine", "elsewhere"), "a number"),
    **dict.fromkeys(("list", "deque", "tuple"), "a sequence"),
    **dict.fromkeys(("set", "frozenset"), "a set"),
    **{"dict": "a dictionary", "generator": "a generator of random numbers"},
    **{"object": "an object", "state_dict": "an object", "enum": "an enum member", "name": "a function or class"},
}


def _class_of_node(node: Any) -> str | None:
    """Numbers, text or a kind of container; None for None and where a node may stand for anything."""
    if isinstance(node, (str, bytes)):
        return "text"
    if isinstance(node, tuple):
        return _CLASSES.get(node[0])
    return None if node is None else "a number"


def _class_of_value(value: Any) -> str | None:
    """The same of a live value."""
    if isinstance(value, enum.Enum):
        return "an enum member"
    if isinstance(value, (str, bytes)):
        return "text"
    if isinstance(value, (bool, int, float, complex, torch.Tensor, np.ndarray, np.generic)):
        return "a number"
    if isinstance(value, dict):
        return "a dictionary"
    if generator_node(value) is not None:
        return "a generator of random numbers"
    kind = sequence_kind(value)
    if kind is not None:
        return _CLASSES[kind]
    if name_of(value) is not None:
        return "a function or class"
    return "an object" if is_object(value) or saves_itself(value) else None


def _is_numbered(key: Any) -> bool:
    return type(key) is tuple and len(key) == 2 and key[0] == "key" and type(key[1]) is int


def _was(node: Any, live: Any) -> str:
    there = "is not there" if live is _ABSENT else f"is {type(live).__qualname__}"
    return f"{there}, it was {node[1] if node[0] in ('object', 'state_dict') else node[0]}"
