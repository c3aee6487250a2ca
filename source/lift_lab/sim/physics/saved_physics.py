"""Saving and restoring the whole state of an engine, from what each engine says it is made of."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy as np
import torch

from lift_lab.utils.errors import NotFoundError, StateMismatchError
from lift_lab.utils.saved_state import check_tensor, copies, copy_into

from .base import Physics

STATE_VERSION = 1
"""Version of the form of a saved state."""


class SavedPhysics(Physics):
    """A :class:`Physics` whose state is a table of live tensors."""

    @abstractmethod
    def _live_state(self) -> dict[str, torch.Tensor]:
        """What the next step starts from and the failures noted, in the engine's precision: live tensors by name."""

    @abstractmethod
    def _model_rows(self) -> dict[str, torch.Tensor]:
        """Model fields that differ between environments: live tensors by name, (num_envs, *shape)."""

    def _model_row(self, name: str) -> torch.Tensor:
        """One of them, which may be shared by all environments until now."""
        return self.randomizable(name)

    def _restore_constants(self) -> None:
        """Derive the constants of the model once its rows were loaded."""

    @abstractmethod
    def _on_state_loaded(self) -> None:
        """Forget what was known of the state before it was loaded."""

    def state_dict(self) -> dict[str, Any]:
        self._follow_model()
        return {
            "engine": self.name,
            "version": STATE_VERSION,
            "state": copies(self._live_state()),
            "fields": copies(self._bound()),
            "model": copies(self._model_rows()),
            "has_own_constants": self._has_own_constants,
            "stale": self._stale_ids(),
            "acceleration": None if self._acceleration is None else self._acceleration.detach().cpu().clone(),
        }

    def check_state_dict(self, state: Any) -> None:
        try:
            self._check_state(state)
        except StateMismatchError:
            raise
        except Exception as error:  # of a state that is no state, anything can be wrong
            raise StateMismatchError(f"the saved state of the physics is not valid: {error}") from error

    def _check_state(self, state: Any) -> None:
        if state["engine"] != self.name:
            raise StateMismatchError(f"the saved state is of the engine '{state['engine']}', this is '{self.name}'")
        if state["version"] != STATE_VERSION:
            found = state["version"]
            raise StateMismatchError(f"the saved state of the physics has version {found}, this is {STATE_VERSION}")
        live = self._live_state()
        for name in live.keys() | state["state"].keys():
            check_tensor(f"physics.{name}", state["state"].get(name), live.get(name))
        for name, values in state["fields"].items():
            try:
                self._field_stage(name)
                shape = (self.num_envs, *self._shape(name))
            except (AttributeError, NotFoundError) as error:
                raise StateMismatchError(f"the saved physics field '{name}' is not in this model") from error
            check_tensor(f"physics.{name}", values, torch.empty(shape, device="meta"))
        for name, values in state["model"].items():
            check_tensor(f"physics.model.{name}", values, self._shared(name).to("meta").to(values.dtype))
        if state["acceleration"] is not None:
            shape = (self.num_envs, self.model.nv)
            check_tensor("physics.acceleration", state["acceleration"], torch.empty(shape, device="meta"))
        stale = state["stale"]
        if stale is not None and not set(stale.tolist()) <= set(range(self.num_envs)):
            raise StateMismatchError("'physics.stale' has to be numbers of environments")

    def load_state_dict(self, state: dict[str, Any]) -> None:
        self.check_state_dict(state)
        for name in state["fields"]:
            self.field(name)
        for name, row in self._model_rows().items():
            if name not in state["model"]:
                copy_into(row, self._shared(name).to(row.dtype))
        for name, values in state["model"].items():
            copy_into(self._model_row(name), values)
        if state["has_own_constants"] or self._has_own_constants:
            self._restore_constants()
            self._has_own_constants = True
        self._inputs = {name: (field, field._version) for name, (field, _) in self._inputs.items()}
        for name, live in self._live_state().items():
            copy_into(live, state["state"][name])
        self.refresh()
        for name, live in self._live_state().items():
            copy_into(live, state["state"][name])
        for name, values in state["fields"].items():
            copy_into(self.field(name), values)
        if state["acceleration"] is not None:
            copy_into(self.acceleration(), state["acceleration"])
        elif self._acceleration is not None:
            copy_into(self._acceleration, torch.zeros_like(self._acceleration))
        stale = state["stale"]
        self._stale[:] = [] if stale is None else [stale.to(self.device)]
        self._on_state_loaded()

    def storages(self) -> set[int]:
        owned = [*self._live_state().values(), *self._bound().values(), *self._model_rows().values()]
        if self._acceleration is not None:
            owned.append(self._acceleration)
        return {tensor.untyped_storage().data_ptr() for tensor in owned if tensor.numel()}

    def _bound(self) -> dict[str, torch.Tensor]:
        return {name: self.field(name) for name in self.bound_fields}

    def _stale_ids(self) -> torch.Tensor | None:
        """Environments that moved since the kinematics were current; None where none did."""
        if not self._stale:
            return None
        some = [env_ids for env_ids in self._stale if env_ids is not None]
        everywhere = len(some) < len(self._stale)
        ids = range(self.num_envs) if everywhere else {int(i) for env_ids in some for i in env_ids}
        return torch.tensor(sorted(ids), dtype=torch.long)

    def _shared(self, name: str) -> torch.Tensor:
        """Values of a model field that all environments have, repeated for each: (num_envs, *shape)."""
        owner, attribute = (self.model.opt, name[4:]) if name.startswith("opt.") else (self.model, name)
        values = getattr(owner, attribute, None)
        if values is None:
            raise StateMismatchError(f"the saved model field 'physics.model.{name}' is not in this model")
        return torch.as_tensor(values).expand(self.num_envs, *np.shape(values))
