"""What a class says about its saved state.

A training saves the attributes of an environment's managers, terms, assets and sensors, so that it can be continued
exactly. A class has a say in that:

- ``unsaved_attributes: ClassVar[frozenset[str]]``: attributes that are no part of the state, because they can be
  computed again or belong to the process (an open file, a window).
- ``on_state_loaded(self) -> None``: called once the attributes have their saved values: forget what was computed from
  other ones.
- ``state_dict(self) -> dict`` and ``load_state_dict(self, state) -> None``, both or neither: the object saves itself,
  and its attributes are not looked at. The dictionary holds tensors, arrays, numbers, text and containers of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch

from .errors import StateMismatchError


def unsaved_attributes(value: Any) -> frozenset[str]:
    """Names of the attributes of an object that its class and the classes above it leave out of its state."""
    names: set[str] = set()
    for cls in type(value).__mro__:
        names.update(vars(cls).get("unsaved_attributes", ()))
    return frozenset(names)


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
