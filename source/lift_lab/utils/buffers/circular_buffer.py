"""A ring of the last values of batched data."""

from __future__ import annotations

from collections.abc import Sequence

import torch


class CircularBuffer:
    """The last ``max_len`` values of batched data; each batch entry can be reset by itself.

    The first value after a reset fills the whole history of its entries. The shape of the data is set by the first
    :meth:`append`. No operation waits for the device.
    """

    def __init__(self, max_len: int, batch_size: int, device: torch.device | str):
        """
        Args:
            max_len: number of values kept, at least 1.
            batch_size: first dimension of the data.
            device: device of the data.

        Raises:
            ValueError: ``max_len`` is less than 1.
        """
        if max_len < 1:
            raise ValueError(f"CircularBuffer: max_len must be at least 1, got {max_len}")
        self._max_len = max_len
        self._batch_size = batch_size
        self._device = device
        self._all = torch.arange(batch_size, device=device)
        self._num_pushes = torch.zeros(batch_size, dtype=torch.long, device=device)
        self._ring: torch.Tensor | None = None  # (max_len, batch_size, ...)
        self._head = -1  # slot of the latest value
        self._some_empty = True  # whether an entry was reset since the last append; kept here to ask no tensor

    @property
    def batch_size(self) -> int:
        """First dimension of the data."""
        return self._batch_size

    @property
    def device(self) -> torch.device | str:
        """Device of the data."""
        return self._device

    @property
    def max_length(self) -> int:
        """Number of values kept."""
        return self._max_len

    @property
    def current_length(self) -> torch.Tensor:
        """Number of values since the last reset, at most :attr:`max_length`. Shape is (batch_size,)."""
        return self._num_pushes.clamp(max=self._max_len)

    @property
    def buffer(self) -> torch.Tensor:
        """All values, oldest first; a copy. Shape is (batch_size, max_length, ...).

        Raises:
            RuntimeError: nothing was appended yet.
        """
        if self._ring is None:
            raise RuntimeError("CircularBuffer: nothing was appended yet")
        return self._ring.roll(self._max_len - self._head - 1, dims=0).transpose(0, 1)

    def reset(self, batch_ids: Sequence[int] | torch.Tensor | None = None) -> None:
        """Empty some batch entries (None: all); their values read as zero until the next append."""
        ids = slice(None) if batch_ids is None else batch_ids
        self._num_pushes[ids] = 0
        self._some_empty = True
        if self._ring is not None:
            self._ring[:, ids] = 0

    def fill(self, data: torch.Tensor, batch_ids: Sequence[int] | torch.Tensor) -> None:
        """Restart some batch entries with a first value, which fills their history, and leave the others unchanged.

        Args:
            data: values of these entries. Shape is (len(batch_ids), ...).
            batch_ids: the entries.
        """
        self._make_ring(data)[:, batch_ids] = data
        self._num_pushes[batch_ids] = 1

    def _make_ring(self, data: torch.Tensor) -> torch.Tensor:
        """The ring; made at the first value, which says what its values are like."""
        if self._ring is None:
            shape = (self._max_len, self._batch_size, *data.shape[1:])
            self._ring = torch.zeros(shape, dtype=data.dtype, device=self._device)
        return self._ring

    def append(self, data: torch.Tensor) -> None:
        """Add the latest value of every batch entry. Shape is (batch_size, ...).

        Raises:
            ValueError: another batch size.
        """
        if data.shape[0] != self._batch_size:
            raise ValueError(f"CircularBuffer: expected a batch of {self._batch_size}, got {data.shape[0]}")
        data = data.to(self._device if self._ring is None else self._ring)
        ring = self._make_ring(data)
        self._head = (self._head + 1) % self._max_len
        ring[self._head] = data
        if self._some_empty:
            empty = (self._num_pushes == 0).view(-1, *[1] * (data.dim() - 1))
            torch.where(empty, data, ring, out=ring)
            self._some_empty = False
        self._num_pushes += 1

    def __getitem__(self, key: torch.Tensor) -> torch.Tensor:
        """The value ``key`` steps before the latest one of each entry, or its oldest. Shape is (batch_size, ...).

        Args:
            key: number of steps back. Shape is (batch_size,).

        Raises:
            ValueError: another batch size.
            RuntimeError: an entry is empty.
        """
        if len(key) != self._batch_size:
            raise ValueError(f"CircularBuffer: expected {self._batch_size} keys, got {len(key)}")
        if self._ring is None or self._some_empty:
            raise RuntimeError("CircularBuffer: an entry is empty; append data after a reset before reading it")
        lag = torch.minimum(key.to(self._num_pushes), self._num_pushes - 1)
        return self._ring[torch.remainder(self._head - lag, self._max_len), self._all]
