"""The last values of one observation term."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

if TYPE_CHECKING:
    from .manager_base import EnvIds


class ObservationHistory:
    """The last ``max_length`` values of a term in every environment, oldest first.

    A push makes a new tensor and a reset only marks environments, so what was handed out is never
    overwritten.
    """

    def __init__(self, max_length: int, num_envs: int, device: str):
        """Start empty."""
        self.max_length = max_length
        self._buffer: torch.Tensor | None = None
        self._num_pushes = 0
        self._pushes_at_reset = torch.zeros(num_envs, dtype=torch.long, device=device)
        self._some_empty = True

    @property
    def buffer(self) -> torch.Tensor | None:
        """The values, shape (num_envs, max_length, ...); None before the first push."""
        return self._buffer

    @property
    def current_length(self) -> torch.Tensor:
        """Values pushed since the last reset, at most ``max_length``. Shape is (num_envs,)."""
        return (self._num_pushes - self._pushes_at_reset).clamp(max=self.max_length)

    def reset(self, env_ids: EnvIds = None) -> None:
        """Empty some environments' history: their next value fills it."""
        self._pushes_at_reset[slice(None) if env_ids is None else env_ids] = self._num_pushes
        self._some_empty = True

    def push(self, value: torch.Tensor) -> torch.Tensor:
        """Append a value of shape (num_envs, ...); returns the history after it."""
        if self._buffer is not None:
            newest = value.unsqueeze(1)
            shifted = torch.cat((self._buffer[:, 1:], newest), dim=1)
            self._buffer = torch.where(self._empty(value), newest, shifted) if self._some_empty else shifted
        else:
            self._buffer = self._filled(value)
        self._some_empty = False
        self._num_pushes += 1
        return self._buffer

    def peek(self, value: torch.Tensor) -> torch.Tensor:
        """The history as it stands, where it is empty the history that ``value`` would fill."""
        if self._buffer is None:
            return self._filled(value)
        if self._some_empty:
            return torch.where(self._empty(value), value.unsqueeze(1), self._buffer)
        return self._buffer

    def _filled(self, value: torch.Tensor) -> torch.Tensor:
        return value.unsqueeze(1).repeat(1, self.max_length, *[1] * (value.ndim - 1))

    def _empty(self, value: torch.Tensor) -> torch.Tensor:
        """Which environments hold nothing, shaped to broadcast with the buffer."""
        empty = self._pushes_at_reset == self._num_pushes
        return empty.view(-1, *[1] * value.ndim)
