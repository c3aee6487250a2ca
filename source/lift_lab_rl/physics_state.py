"""The whole state of a physics engine, in the engine's own precision.

The engines' interface writes float32 state; continuing a run bit by bit needs more: the solver's warm start, float64
rows, model fields that differ between environments with the constants derived from them, and what the engine has noted
but not reported yet. This module knows where each engine keeps them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from lift_lab.sim.physics.base import RANDOMIZABLE_FIELDS, STATE_FIELDS, Physics
from lift_lab.utils.errors import NotFoundError

from .state_restore import StateMismatchError, copy_into

_FLAGS = {"native": ("_failures", "_forces_unchecked", "_looked"), "warp": ("_looked", "_checked")}
"""Attributes of the engines that say which failures were looked for."""

_DERIVED = ("body_invweight0", "dof_invweight0", "body_subtreemass")
"""Model fields of which at least one differs between environments once constants were derived again."""


def physics_state(physics: Physics) -> dict[str, Any]:
    """State, fields of the last step, model fields that differ, and failures to report; copies on the CPU."""
    return {
        "engine": physics.name,
        "rows": _copies(_state_arrays(physics)),
        "fields": _copies(_bound(physics)),
        "model": _copies(_randomised(physics)),
        "derived": _constants_differ(physics),
        "notes": _copies(_notes(physics)),
        "flags": {name: getattr(physics, name) for name in _FLAGS[physics.name]},
        "stale": _stale(physics),
        "acceleration": None if physics._acceleration is None else physics._acceleration.detach().cpu().clone(),
    }


def check_physics_state(physics: Physics, state: dict[str, Any]) -> None:
    """Check that a state of :func:`physics_state` can be written back; changes nothing that matters.

    Raises:
        StateMismatchError: the state is of another engine, or of another number of environments or model.
    """
    if state["engine"] != physics.name:
        raise StateMismatchError(
            f"the saved state is of the engine '{state['engine']}', this run uses '{physics.name}'"
        )
    for part, live in (("rows", _state_arrays(physics)), ("notes", _notes(physics))):
        for name in live.keys() | state[part].keys():
            _check_alike(name, live.get(name), state[part].get(name))
    for name, values in state["fields"].items():
        try:
            shape = (physics.num_envs, *physics._shape(name))
            physics._field_stage(name)
        except (AttributeError, NotFoundError) as error:
            raise StateMismatchError(f"the saved state has the physics field '{name}', this model has not") from error
        _check_alike(name, torch.empty(shape, device="meta"), values)
    for name, values in state["model"].items():
        live = _model_values(physics, name)
        if not isinstance(values, torch.Tensor) or values.shape[:1] != (physics.num_envs,) or live is None:
            raise StateMismatchError(f"the saved state has the model field '{name}', which is not of this model")
        shape = live.shape if name != "bvh_aabb" else (values.shape[1], *live.shape[1:])  # holds the bodies' alone
        _check_alike(name, torch.empty((physics.num_envs, *shape), device="meta"), values, any_type=True)
    flags, stale = state["flags"], state["stale"]
    if flags.keys() != set(_FLAGS[physics.name]) or not all(isinstance(flag, bool) for flag in flags.values()):
        raise StateMismatchError("the saved state of the physics is of another version")
    if stale is not None and not set(stale.tolist()) <= set(range(physics.num_envs)):
        raise StateMismatchError("the saved physics state 'stale' has to be numbers of environments")
    if state["acceleration"] is not None:
        shape = (physics.num_envs, physics.model.nv)
        _check_alike("acceleration", torch.empty(shape, device="meta"), state["acceleration"])


def load_physics_state(physics: Physics, state: dict[str, Any]) -> None:
    """Write a state of :func:`physics_state` back that :func:`check_physics_state` has found right.

    Raises:
        PhysicsError: the constants of the saved model cannot be derived.
    """
    for name in state["fields"]:
        physics.field(name)
    for name in _randomised(physics).keys() - state["model"].keys():
        _write_model(physics, name, torch.as_tensor(_model_values(physics, name)))
    for name, values in state["model"].items():
        _write_model(physics, name, values)
    if physics.name == "native" and (state["derived"] or _constants_differ(physics)):
        physics.recompute_constants()
    for name, array in _state_arrays(physics).items():
        copy_into(array, state["rows"][name])
    physics.refresh()
    for name, values in state["fields"].items():
        copy_into(physics.field(name), values)
    for name, array in _notes(physics).items():
        copy_into(array, state["notes"][name])
    for name, value in state["flags"].items():
        setattr(physics, name, bool(value))
    stale = state["stale"]
    physics._stale[:] = [] if stale is None else [stale.to(physics.device)]
    if state["acceleration"] is not None:
        copy_into(physics.acceleration(), state["acceleration"])
    elif physics._acceleration is not None:
        copy_into(physics._acceleration, torch.zeros_like(physics._acceleration))


def physics_storages(physics: Physics) -> set[int]:
    """Addresses of the memory that the engine owns and restores itself."""
    parts = (_bound(physics), _state_arrays(physics), _randomised(physics), _notes(physics))
    owned = [tensor for part in parts for tensor in part.values()]
    if physics._acceleration is not None:
        owned.append(physics._acceleration)
    return {tensor.untyped_storage().data_ptr() for tensor in owned if tensor.numel()}


def _copies(tensors: dict[str, torch.Tensor]) -> dict[str, torch.Tensor]:
    return {name: tensor.detach().cpu().clone() for name, tensor in tensors.items()}


def _check_alike(name: str, live: torch.Tensor | None, saved: Any, any_type: bool = False) -> None:
    if live is None or not isinstance(saved, torch.Tensor):
        raise StateMismatchError(f"the saved physics state '{name}' is not that of this engine")
    if live.shape != saved.shape:
        found, wanted = tuple(saved.shape), tuple(live.shape)
        raise StateMismatchError(f"the saved physics state '{name}' has shape {found}, this model needs {wanted}")
    if live.dtype != saved.dtype and not any_type:
        raise StateMismatchError(f"the saved physics state '{name}' is of type {saved.dtype}, not {live.dtype}")


def _bound(physics: Physics) -> dict[str, torch.Tensor]:
    """Fields in use: name -> the engine's live tensor."""
    return {name: physics.field(name) for name in physics.bound_fields}


def _state_arrays(physics: Any) -> dict[str, torch.Tensor]:
    """What the next step starts from, as live tensors."""
    if physics.name == "native":
        return {"state": torch.from_numpy(physics._batch.state)}
    return {name: physics._state_tensor(name) for name in (*STATE_FIELDS, "qacc_warmstart")}


def _notes(physics: Any) -> dict[str, torch.Tensor]:
    """Failures that the engine has noted and not reported, as live tensors."""
    if physics.name == "native":
        arrays = {"nonfinite": physics._nonfinite, "overflow": physics._overflow, "warnings": physics._batch.warning}
        return {name: torch.from_numpy(array) for name, array in arrays.items()}
    return {"nonfinite": physics._nonfinite, "overflow": physics._overflow, "overflow_bits": physics._overflow_bits}


def _stale(physics: Physics) -> torch.Tensor | None:
    """Ids of the environments that moved since the kinematics were current; None where none did."""
    if not physics._stale:
        return None
    ids: set[int] = set()
    for env_ids in physics._stale:
        ids.update(range(physics.num_envs) if env_ids is None else torch.as_tensor(env_ids).tolist())
    return torch.tensor(sorted(ids), dtype=torch.long)


# -- the model


def _randomised(physics: Any) -> dict[str, torch.Tensor]:
    """Model fields that differ between environments, as live tensors."""
    if physics.name == "native":
        return {name: torch.from_numpy(array) for name, array in physics._batch._expanded.items()}
    return dict(physics._randomized)


def _constants_differ(physics: Any) -> bool:
    """Whether constants of the model were derived for each environment."""
    if physics.name == "native":
        return any(physics._batch.expanded(name) is not None for name in _DERIVED)
    return any(name in physics._randomized for name in _DERIVED)


def _model_values(physics: Any, name: str) -> np.ndarray | None:
    """A field of the model that all environments share; None where there is none of that name."""
    owner, attribute = (physics.model.opt, name[4:]) if name.startswith("opt.") else (physics.model, name)
    values = getattr(owner, attribute, None)
    if values is None:
        return None
    values = np.asarray(values)
    expanded = _randomised(physics).get(name)
    return values if expanded is None else values[: expanded.shape[1]] if values.ndim else values


def _write_model(physics: Any, name: str, values: torch.Tensor) -> None:
    """Write values of each environment, or one for all, into a field of the model."""
    if name in RANDOMIZABLE_FIELDS:
        target = physics.randomizable(name)
    else:
        target = torch.from_numpy(physics._batch.expand(name)) if physics.name == "native" else physics._expand(name)
    copy_into(target, values.expand(target.shape).to(target.dtype))
