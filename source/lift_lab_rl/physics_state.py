"""The whole state of a physics engine, in the engine's own precision.

The engines' interface writes float32 state; continuing a run bit by bit needs more: the solver's warm start, float64
rows, and the model fields that were randomised. This module knows where each engine keeps them.
"""

from __future__ import annotations

from typing import Any

import torch

from lift_lab.sim.physics.base import RANDOMIZABLE_FIELDS, STATE_FIELDS, Physics
from lift_lab.utils.errors import ConfigError


def physics_state(physics: Physics) -> dict[str, Any]:
    """State, fields of the last step, and randomised model fields; copies on the CPU."""
    fields = {name: tensor.detach().cpu().clone() for name, tensor in _bound(physics).items()}
    expanded = {name: tensor.detach().cpu().clone() for name, tensor in _randomised(physics).items()}
    rows = {name: tensor.detach().cpu().clone() for name, tensor in _state_arrays(physics).items()}
    return {"engine": physics.name, "rows": rows, "fields": fields, "model": expanded}


def load_physics_state(physics: Physics, state: dict[str, Any]) -> None:
    """Write a state of :func:`physics_state` back.

    Raises:
        ConfigError: the state is of another engine, or of another number of environments or model.
    """
    if state["engine"] != physics.name:
        raise ConfigError(f"the saved state is of the engine '{state['engine']}', this run uses '{physics.name}'")
    for name in state["fields"]:
        physics.field(name)
    for name, values in state["model"].items():
        physics.randomizable(name).copy_(values)
    if state["model"]:
        physics.recompute_constants()
    arrays = _state_arrays(physics)
    for name, values in state["rows"].items():
        if arrays[name].shape != values.shape:
            found, saved = tuple(arrays[name].shape), tuple(values.shape)
            raise ConfigError(f"the saved physics state '{name}' has shape {saved}, this model needs {found}")
        arrays[name].copy_(values)
    physics.refresh()
    for name, values in state["fields"].items():
        physics.field(name).copy_(values)


def physics_storages(physics: Physics) -> set[int]:
    """Addresses of the memory that the engine owns and restores itself."""
    owned = [*_bound(physics).values(), *_state_arrays(physics).values(), *_randomised(physics).values()]
    return {tensor.untyped_storage().data_ptr() for tensor in owned if tensor.numel()}


def _bound(physics: Physics) -> dict[str, torch.Tensor]:
    """Fields in use: name -> the engine's live tensor."""
    return {name: physics.field(name) for name in physics.bound_fields}


def _state_arrays(physics: Any) -> dict[str, torch.Tensor]:
    """What the next step starts from, as live tensors."""
    if physics.name == "native":
        return {"state": torch.from_numpy(physics._batch.state)}
    return {name: physics._state_tensor(name) for name in (*STATE_FIELDS, "qacc_warmstart")}


def _randomised(physics: Any) -> dict[str, torch.Tensor]:
    """Model fields that differ between environments, as live tensors."""
    names = physics._batch._expanded if physics.name == "native" else physics._randomized
    return {name: physics.randomizable(name) for name in names if name in RANDOMIZABLE_FIELDS}
