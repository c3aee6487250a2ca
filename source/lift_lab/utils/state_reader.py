"""Put objects into a state that :mod:`.state_writer` wrote down.

First the whole tree is compared with the live objects. A state of something else is refused before anything is changed.
"""

from __future__ import annotations

import enum
import random
from collections import deque
from collections.abc import Callable, Mapping, Set
from typing import Any

import numpy as np
import torch

from .errors import StateMismatchError
from .saved_state import Stateful, Stateless, attributes_of, copy_into
from .state_writer import (
    DICTS,
    GENERATORS,
    PLAIN,
    SEQUENCES,
    StateWriter,
    bytes_of,
    has_attributes,
    is_data,
    is_no_state,
    parts_of,
    saves_itself,
    view_of,
)

_KINDS = (
    ("text", (str, bytes)),
    ("a number", (bool, int, float, complex, torch.Tensor, np.ndarray, np.generic)),
    ("a sequence", (list, deque, tuple)),
    ("a set", (set, frozenset)),
    ("a dictionary", (dict,)),
    ("a generator", tuple(kind for kind, _, _ in GENERATORS.values())),
)
_KIND_OF_NODE = {
    **dict.fromkeys(("array", "scalar", "engine", "on"), "a number"),
    **dict.fromkeys(("list", "deque", "tuple"), "a sequence"),
    **{"set": "a set", "frozenset": "a set", "dict": "a dictionary", "generator": "a generator"},
    **dict.fromkeys(("object", "own", "enum"), "an object"),
}


def _kind_of(live: Any) -> str | None:
    """What kind of value a live one is; None for None and where it says nothing."""
    if live is None or isinstance(live, Stateless):
        return None
    if isinstance(live, enum.Enum):
        return "an object"
    return next((kind for kind, classes in _KINDS if isinstance(live, classes)), "an object")


def _kind_of_node(node: Any) -> str | None:
    return _KIND_OF_NODE.get(node[0]) if isinstance(node, tuple) else _kind_of(node)


_READ = {
    **dict.fromkeys(("list", "deque"), "_list"),
    **{"tuple": "_tuple", "set": "_set", "frozenset": "_new", "dict": "_dict", "object": "_object", "own": "_own"},
    **{"array": "_array", "scalar": "_scalar", "generator": "_generator", "enum": "_enum"},
    **{"engine": "_of_engine", "kept": "_kept", "on": "_elsewhere"},
}
"""Which method reads a kind of node."""


class _Absent:
    """Stands for what is not there."""


_ABSENT = _Absent()


class StateReader:
    """Plans how objects get their saved values, then does it.

    Tensors and containers are written in place wherever that gives the same structure, because other parts of the
    program may hold them, too.
    """

    def __init__(
        self,
        device: str | torch.device = "cpu",
        engine: Set[int] = frozenset(),
        known: Mapping[str, Any] | None = None,
    ):
        """Prepare.

        Args:
            device: where new tensors are made.
            engine: addresses of memory that the physics engine restores.
            known: objects by the path under which they are saved.
        """
        self._device = device
        self._engine = engine
        self._actions: list[Callable[[], Any]] = []
        self._finals: dict[str, Any] = dict(known or {})  # path -> the container or object that will be there
        self._taken: set[int] = set()  # ids of live values that already have their place
        self._stateful: list[Stateful] = []
        self._tensors: dict[int, torch.Tensor] = {}  # id of a saved tensor -> the one that takes its values
        self._live_of_saved: dict[int, torch.UntypedStorage] = {}
        self._saved_of_live: dict[int, int] = {}
        self._alive: list[Any] = []  # so that an id is not given twice

    def plan(self, live: Any, node: Any, path: str) -> Any:
        """Compare a value with a node.

        Args:
            live: the value.
            node: the node.
            path: where it is.

        Returns:
            What will be in its place; ``live`` itself, if it only has to be written into.

        Raises:
            StateMismatchError: the state is of something else; names the first thing that differs.
        """
        try:
            return self._value(live, node, path)
        except StateMismatchError:
            raise
        except Exception as error:  # of a state that is no state, anything can be wrong
            raise StateMismatchError(f"the saved state is not valid: {' '.join(str(error).split())[:120]}") from error

    def apply(self) -> None:
        """Write the values, then tell the objects."""
        with torch.no_grad():
            for action in self._actions:
                action()
        for value in self._stateful:
            value.on_state_loaded()

    def _value(self, live: Any, node: Any, path: str) -> Any:
        if live is not _ABSENT and live is not None and type(live) is not type(node):
            self._check_kind(live, node, path)
        if isinstance(node, torch.Tensor):
            return self._tensor(live, node)
        if type(node) in PLAIN:
            return live if type(live) is type(node) and repr(live) == repr(node) else node  # also NaN and -0.0
        if node[0] == "same":
            return self._finals[node[1]]
        if node[0] not in _READ:
            raise ValueError(f"'{path}' is of an unknown kind")
        final = self._finals[path] = getattr(self, _READ[node[0]])(live, node, path)
        self._alive.append(final)
        return final

    def _check_kind(self, live: Any, node: Any, path: str) -> None:
        """Numbers (also in tensors), text and containers do not become one another while an environment runs."""
        here, there = _kind_of(live), _kind_of_node(node)
        if None not in (here, there) and here != there:
            raise self._mismatch(path, f"is of type {type(live).__name__}, it was {there}")

    def _mismatch(self, path: str, problem: str) -> StateMismatchError:
        return StateMismatchError(f"the saved state is of another environment: '{path}' {problem}")

    def _differs(self, path: str, node: Any, live: Any) -> StateMismatchError:
        there = "is not there" if live is _ABSENT else f"is {type(live).__qualname__}"
        return self._mismatch(path, f"{there}, it was {node[1] if node[0] in ('object', 'own', 'enum') else node[0]}")

    def _free(self, live: Any) -> bool:
        """Whether a live container or object has no place yet; it has one now."""
        if id(live) in self._taken:
            return False
        self._taken.add(id(live))
        self._alive.append(live)
        return True

    def _check_may_go(self, live: Any, path: str) -> None:
        """What the saved state does not have can be removed if it is data."""
        if not is_data(StateWriter(self._device, self._engine).node(live, path)):
            raise self._mismatch(path, "is not in it")

    def _kept(self, live: Any, node: Any, path: str) -> Any:
        if live is _ABSENT:
            raise self._mismatch(path, "is not there")
        return live

    # -- containers

    def _new(self, live: Any, node: Any, path: str) -> Any:
        """A new value from a node alone."""
        if not is_data(node):
            raise self._differs(path, node, live)
        kind, *rest = node
        if kind == "dict":
            made: Any = DICTS[rest[0]]()
            for key, entry in rest[1]:
                made[key] = self._value(_ABSENT, entry, f"{path}[{key!r}]")
            return made
        items = [self._value(_ABSENT, entry, f"{path}[{k}]") for k, entry in enumerate(rest[-1])]
        return deque(items, rest[0]) if kind == "deque" else SEQUENCES[kind](items)

    def _list(self, live: Any, node: Any, path: str) -> Any:
        if not isinstance(live, SEQUENCES[node[0]]) or not self._free(live):
            return self._new(live, node, path)
        items, before = node[-1], list(live)
        for k, entry in enumerate(before[len(items) :], len(items)):
            self._check_may_go(entry, f"{path}[{k}]")
        before += [_ABSENT] * (len(items) - len(before))
        finals = [self._value(before[k], entry, f"{path}[{k}]") for k, entry in enumerate(items)]
        if len(live) != len(finals) or any(a is not b for a, b in zip(live, finals, strict=True)):
            self._actions.append(lambda: (live.clear(), live.extend(finals)))
        return live

    def _tuple(self, live: Any, node: Any, path: str) -> Any:
        items = node[1]
        if not isinstance(live, tuple) or len(live) != len(items):
            return self._new(live, node, path)
        pairs = enumerate(zip(live, items, strict=True))
        finals = [self._value(entry, item, f"{path}[{k}]") for k, (entry, item) in pairs]
        if all(a is b for a, b in zip(live, finals, strict=True)):
            return live
        return type(live)(*finals) if hasattr(live, "_fields") else type(live)(finals)

    def _set(self, live: Any, node: Any, path: str) -> Any:
        if not isinstance(live, set) or not self._free(live):
            return self._new(live, node, path)
        if live != set(node[1]):
            self._actions.append(lambda: (live.clear(), live.update(node[1])))
        return live

    def _dict(self, live: Any, node: Any, path: str) -> Any:
        if not isinstance(live, dict) or not self._free(live):
            return self._new(live, node, path)
        saved = dict(node[2])
        for key in live.keys() - saved.keys():
            self._check_may_go(live[key], f"{path}[{key!r}]")
        finals = {
            key: self._value(live.get(key, _ABSENT) if key in live else _ABSENT, entry, f"{path}[{key!r}]")
            for key, entry in saved.items()
        }
        if list(live) != list(finals) or any(live[key] is not final for key, final in finals.items()):

            def fill() -> None:
                live.clear()
                for key, final in finals.items():
                    live[key] = final

            self._actions.append(fill)
        return live

    # -- objects

    def _object(self, live: Any, node: Any, path: str) -> Any:
        _, cls, version, saved = node
        if not has_attributes(live) or type(live).__qualname__ != cls or not self._free(live):
            raise self._differs(path, node, live)
        self._finals[path] = live
        left_out: Set[str] = frozenset()
        if isinstance(live, Stateful):
            if version > live.state_version:
                raise self._mismatch(path, f"has the form of version {version}, this is version {live.state_version}")
            if version < live.state_version:
                saved = live.upgrade_state(dict(saved), version)
            self._stateful.append(live)
            left_out = attributes_of(live).keys() - live.state_parts().keys()
        prefix, here = f"{path}." if path else "", parts_of(live)
        for name in sorted(here.keys() - saved.keys()):
            if here[name] is not None:
                raise self._mismatch(f"{prefix}{name}", "is not in it")
        for name, entry in saved.items():
            if name in left_out or (name not in here and is_no_state(getattr(live, name, None))):
                continue
            before = here.get(name, _ABSENT)
            final = self._value(before, entry, f"{prefix}{name}")
            if final is not before:
                self._actions.append(lambda name=name, final=final: object.__setattr__(live, name, final))
        return live

    def _own(self, live: Any, node: Any, path: str) -> Any:
        if not saves_itself(live) or type(live).__qualname__ != node[1]:
            raise self._differs(path, node, live)
        content = self._value(_ABSENT, node[2], f"{path}.state_dict()")

        def load() -> None:
            try:
                live.load_state_dict(content)
            except Exception as error:  # of the class of somebody else
                raise StateMismatchError(f"'{path}' does not take its saved state: {error}") from error

        self._actions.append(load)
        return live

    def _enum(self, live: Any, node: Any, path: str) -> Any:
        if not isinstance(live, enum.Enum) or type(live).__qualname__ != node[1]:
            raise self._differs(path, node, live)
        return type(live)[node[2]]

    # -- arrays and generators

    def _array(self, live: Any, node: Any, path: str) -> Any:
        values = _array_of(node)
        fits = isinstance(live, np.ndarray) and (live.shape, live.dtype) == (values.shape, values.dtype)
        if not fits or not self._free(live):
            return values
        if live.tobytes() != values.tobytes():
            if not live.flags.writeable:
                raise StateMismatchError(f"'{path}' is an array that cannot be written to")
            self._actions.append(lambda: np.copyto(live, values))
        return live

    def _scalar(self, live: Any, node: Any, path: str) -> Any:
        return _array_of(node)[()]

    def _generator(self, live: Any, node: Any, path: str) -> Any:
        _, kind, where, state = node
        cls, _, write = GENERATORS[kind]
        state = self._value(_ABSENT, state, f"{path}.state")
        new = _new_generator(kind, where, state)
        write(new, state)  # a state that is no state is noticed here
        if not isinstance(live, cls) or not self._free(live):
            return new
        self._actions.append(lambda: write(live, state))
        return live

    # -- tensors

    def _of_engine(self, live: Any, node: Any, path: str) -> Any:
        if not isinstance(live, torch.Tensor) or live.untyped_storage().data_ptr() not in self._engine:
            raise self._mismatch(path, "was a tensor of the physics engine")
        return live

    def _elsewhere(self, live: Any, node: Any, path: str) -> Any:
        return self._tensor(live, node[2], node[1])

    def _tensor(self, live: Any, saved: torch.Tensor, device: str | None = None) -> torch.Tensor:
        known = self._tensors.get(id(saved))
        if known is None:
            known = self._tensors[id(saved)] = self._target(live, saved, device)
            self._alive.append(saved)
        return known

    def _target(self, live: Any, saved: torch.Tensor, device: str | None) -> torch.Tensor:
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
        where = device or (live.device if isinstance(live, torch.Tensor) else self._device)
        if not address:
            return torch.empty_like(saved, device=where)
        if address not in self._live_of_saved:
            self._live_of_saved[address] = bytes_of(source).to(where, copy=True).untyped_storage()
        made = view_of(self._live_of_saved[address], saved, self._live_of_saved[address].device)
        self._actions.append(lambda: copy_into(made, saved))
        return made

    def _lies_alike(self, live: Any, saved: torch.Tensor) -> bool:
        if not isinstance(live, torch.Tensor) or live.layout != torch.strided:
            return False
        mine, source = live.untyped_storage(), saved.untyped_storage()
        if mine.data_ptr() in self._engine and live.numel():
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


def _array_of(node: tuple) -> np.ndarray:
    _, descr, shape, data = node
    dtype = np.lib.format.descr_to_dtype(descr)
    size = int(np.prod(shape, dtype=np.int64)) * dtype.itemsize
    return np.frombuffer(data.numpy().tobytes()[:size], dtype).reshape(shape).copy()


def _new_generator(kind: str, where: str, state: Any) -> Any:
    if kind == "torch":
        return torch.Generator(device=where)
    if kind == "python":
        return random.Random()
    bits = getattr(np.random, state["bit_generator"])()
    return np.random.Generator(bits) if kind == "numpy" else np.random.RandomState(bits)


def _same_bytes(a: torch.Tensor, b: torch.Tensor) -> bool:
    if torch.equal(a, b.to(a.device)):
        # 0.0 equals -0.0
        return not a.is_floating_point() or torch.equal(torch.signbit(a), torch.signbit(b.to(a.device)))
    return False
