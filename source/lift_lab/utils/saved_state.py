"""Saved state of objects: which attributes belong to it.

A training saves the state of its environment, so that it can be continued exactly: see
:meth:`lift_lab.envs.ManagerBasedEnv.state_dict`. By default the state of an object is every attribute: tensors, arrays,
numbers, text, generators of random numbers and containers of these. The same holds for objects that it refers to.
Configurations, functions and objects of the engine are no state. To change this, derive from :class:`Stateful`, or
define ``state_dict`` and ``load_state_dict`` as torch's modules do.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import torch

from .errors import StateMismatchError


class Stateful:
    """An object with a state. Managers, terms, assets, sensors and actuators are such."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset()
    """Attributes that are no state: they never change, follow from others, or belong to the process. A class adds its
    own to those of the classes above it."""

    state_version: ClassVar[int] = 1
    """To be raised when saved attributes are renamed or get another meaning, with a case in :meth:`upgrade_state`."""

    @classmethod
    def upgrade_state(cls, attributes: dict[str, Any], version: int) -> dict[str, Any]:
        """Turn attributes that an older version of the class has saved into those of the present one.

        Args:
            attributes: saved values by attribute; those inside of containers are as the file has them.
            version: the older :attr:`state_version`.
        """
        return attributes

    def state_parts(self) -> dict[str, Any]:
        """Return the values of the state by the name under which they are saved.

        These are the attributes. A class may add objects that are not among its attributes.
        """
        left_out = unsaved_attributes(type(self))
        return {name: value for name, value in attributes_of(self).items() if name not in left_out}

    def on_state_loaded(self) -> None:
        """Forget what was computed from the state before this one was loaded."""

    def named_objects(self) -> dict[str, Any]:
        """Objects that are saved under names of their own, by name: where this one holds them, it refers to them."""
        return {}

    def state_dict(self) -> dict[str, Any]:
        """The state as copies on the CPU: tensors and plain values."""
        from .state_writer import StateWriter

        known = {id(value): name for name, value in self.named_objects().items()}
        return StateWriter(known=known).parts(self, "")

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Continue from a state of :meth:`state_dict`.

        Raises:
            StateMismatchError: the state is of something else; nothing has changed then.
        """
        from .state_reader import StateReader

        reader = StateReader(known=self.named_objects())
        reader.plan(self, ("object", type(self).__qualname__, self.state_version, state), "")
        reader.apply()


class Stateless:
    """Base class of objects that are never part of a state: an engine, a window, a view of other objects."""


def attributes_of(value: Any) -> dict[str, Any]:
    """Attributes of an object: those in its dictionary and those in slots."""
    found: Any = object.__getstate__(value)
    plain, slots = found if isinstance(found, tuple) else (found, None)
    return (plain or {}) | (slots or {})


def unsaved_attributes(cls: type) -> frozenset[str]:
    """Attributes that a class and the classes above it leave out of the state."""
    return frozenset().union(*(vars(base).get("unsaved_attributes", ()) for base in cls.__mro__))


def copies(tensors: Mapping[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    """Copies of tensors, on the CPU."""
    return {name: tensor.detach().to("cpu", copy=True) for name, tensor in tensors.items()}


def copy_into(target: torch.Tensor, values: torch.Tensor) -> None:
    """Write values into a tensor in place, also into one of inference mode or one that repeats its entries."""
    for dim, stride in enumerate(target.stride()):
        if stride == 0 and target.shape[dim] > 1:
            target, values = target.narrow(dim, 0, 1), values.narrow(dim, 0, 1)
    with torch.inference_mode(target.is_inference()), torch.no_grad():  # in this order: the first allows gradients
        target.copy_(values)


def check_tensor(name: str, saved: Any, live: torch.Tensor | None) -> None:
    """Check that a saved tensor has shape and type of a live one.

    Raises:
        StateMismatchError: it has not, or one of the two is not there.
    """
    if live is None or not isinstance(saved, torch.Tensor):
        raise StateMismatchError(f"the saved state '{name}' {'is no tensor' if live is not None else 'is unknown'}")
    if saved.shape != live.shape:
        found, wanted = tuple(saved.shape), tuple(live.shape)
        raise StateMismatchError(f"the saved state '{name}' has shape {found}, here it is {wanted}")
    if saved.dtype != live.dtype:
        raise StateMismatchError(f"the saved state '{name}' is of type {saved.dtype}, here it is {live.dtype}")
