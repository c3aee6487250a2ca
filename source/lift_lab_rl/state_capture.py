"""Write down the state of a graph of objects as one tree of tensors and plain values."""

from __future__ import annotations

from collections.abc import Callable, Set
from typing import Any

import torch

from lift_lab.utils.saved_state import unsaved_attributes

from .state_nodes import (
    attributes_of,
    dict_type,
    is_key,
    is_object,
    is_plain,
    leaf_node,
    never_changes,
    saves_itself,
    sequence_kind,
)


class Capture:
    """Walks the objects below a root.

    Tensors are copied with their memory: those that share it here share it in the copy.

    Attributes:
        unsaved: path and type of every object whose state could not be written down.
    """

    def __init__(
        self, engine_storages: Set[int], is_left_out: Callable[[Any], bool], device: str | torch.device = "cpu"
    ):
        """Prepare a walk.

        Args:
            engine_storages: addresses of memory that the physics engine restores.
            is_left_out: whether an object is no part of the state.
            device: where most tensors are.
        """
        self._device = torch.device(device)
        self.unsaved: list[str] = []
        self._engine_storages = engine_storages
        self._is_left_out = is_left_out
        self._paths: dict[int, str] = {}  # of containers and objects: where they were met first
        self._alive: list[Any] = []  # so that an id is not given twice
        self._storages: dict[int, torch.UntypedStorage] = {}
        self._tensors: dict[int, torch.Tensor] = {}

    def node(self, value: Any, path: str) -> Any:
        """A value as a node (see :mod:`.state_nodes`).

        Args:
            value: any object.
            path: where it is, for references and messages.
        """
        if is_plain(value):
            return value
        if isinstance(value, torch.Tensor):
            copy = self._tensor(value, path)
            here = value.device.type == self._device.type or not isinstance(copy, torch.Tensor)
            return copy if here else ("elsewhere", str(value.device), copy)
        if id(value) in self._paths:
            return ("same", self._paths[id(value)])
        if self._is_left_out(value):
            return ("fixed",)
        node = self._below(value, path)
        return node

    def _met(self, value: Any, path: str) -> None:
        self._paths[id(value)] = path
        self._alive.append(value)

    def _below(self, value: Any, path: str) -> Any:
        kind = sequence_kind(value)
        if kind in ("set", "frozenset"):
            self._met(value, path)
            return (kind, list(value)) if all(map(is_key, value)) else self._lost(value, path)
        if kind is not None:
            self._met(value, path)
            items = [self.node(item, f"{path}[{k}]") for k, item in enumerate(value)]
            return (kind, value.maxlen, items) if kind == "deque" else (kind, items)
        if isinstance(value, dict):
            self._met(value, path)
            entries = [
                ((key if is_key(key) else ("key", k)), self.node(entry, f"{path}[{key!r}]"))
                for k, (key, entry) in enumerate(list(value.items()))
            ]
            return ("dict", dict_type(value), entries)
        leaf = leaf_node(value)
        if leaf is not None:
            if leaf[0] in ("array", "generator"):
                self._met(value, path)
            owner = getattr(value, "__self__", None)
            if leaf[0] == "name" and owner is not None and not isinstance(owner, type) and is_object(owner):
                return (*leaf, self.node(owner, f"{path}.__self__"))
            return leaf
        if saves_itself(value):
            self._met(value, path)
            return ("state_dict", type(value).__qualname__, self.node(value.state_dict(), f"{path}.state_dict()"))
        if is_object(value):
            self._met(value, path)
            left_out = unsaved_attributes(value)
            attributes = {
                name: self.node(item, f"{path}.{name}" if path else name)
                for name, item in attributes_of(value).items()
                if name not in left_out and not self._is_left_out(item)
            }
            return ("object", type(value).__qualname__, attributes)
        return ("fixed",) if never_changes(value) else self._lost(value, path)

    def _lost(self, value: Any, path: str) -> tuple:
        self.unsaved.append(f"{path} ({type(value).__module__}.{type(value).__qualname__})")
        return ("fixed",)

    def _tensor(self, value: torch.Tensor, path: str) -> Any:
        if id(value) in self._tensors:
            return self._tensors[id(value)]
        if value.layout != torch.strided or value.is_quantized:
            return self._lost(value, path)
        storage = value.untyped_storage()
        address = storage.data_ptr()
        if address in self._engine_storages and value.numel():
            return ("engine", list(value.shape))
        self._alive.append(value)
        if not address:
            copy = torch.empty_like(value.detach(), device="cpu")
        else:
            if address not in self._storages:
                self._storages[address] = bytes_of(storage).to("cpu", copy=True).untyped_storage()
            copy = view_of(self._storages[address], value, "cpu")
        self._tensors[id(value)] = copy
        return copy


def bytes_of(storage: torch.UntypedStorage) -> torch.Tensor:
    """A storage as a tensor of bytes on the same memory."""
    with torch.inference_mode(False):
        return torch.empty(0, dtype=torch.uint8, device=storage.device).set_(storage)


def view_of(storage: torch.UntypedStorage, like: torch.Tensor, device: Any) -> torch.Tensor:
    """A tensor on a storage with type, shape and place in memory of another one."""
    with torch.inference_mode(False):
        empty = torch.empty(0, dtype=like.dtype, device=device)
        return empty.set_(storage, like.storage_offset(), like.shape, like.stride())
