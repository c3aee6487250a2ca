"""An action term that keeps its raw and its processed action in tensors of its own."""

from __future__ import annotations

import torch

from lift_lab.managers import ActionTerm

__all__ = ["StoredAction"]


class StoredAction(ActionTerm):
    """Base of the terms here: ``process_actions`` writes both tensors."""

    _raw_actions: torch.Tensor
    _processed_actions: torch.Tensor

    @property
    def raw_actions(self) -> torch.Tensor:
        """The action as it came in, shape (num_envs, action_dim)."""
        return self._raw_actions

    @property
    def processed_actions(self) -> torch.Tensor:
        """Processed action, shape (num_envs, number of targets)."""
        return self._processed_actions
