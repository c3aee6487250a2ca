"""Base of the modifiers that keep state between calls."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

if TYPE_CHECKING:
    from .modifier_cfg import ModifierCfg


class ModifierBase(ABC):
    """A modifier with state for each environment."""

    def __init__(self, cfg: ModifierCfg, data_dim: tuple[int, ...], device: torch.device | str) -> None:
        """
        Args:
            cfg: the configuration.
            data_dim: shape of the data; the first dimension is the environment.
            device: device of the data.
        """
        self._cfg = cfg
        self._data_dim = tuple(data_dim)
        self._device = device

    @abstractmethod
    def reset(self, env_ids: Sequence[int] | torch.Tensor | None = None) -> None:
        """Reset the state of some environments (None: all)."""

    @abstractmethod
    def __call__(self, data: torch.Tensor) -> torch.Tensor:
        """The modified data, of the same shape."""
