"""A delay line with its own lag for each batch entry."""

from __future__ import annotations

from collections.abc import Sequence

import torch

from .circular_buffer import CircularBuffer


class DelayBuffer:
    """Returns what was put in some steps ago; without a lag, what was just put in.

    Where fewer values than the lag were put in since the reset, the oldest of them is returned.
    """

    def __init__(self, history_length: int, batch_size: int, device: torch.device | str):
        """
        Args:
            history_length: greatest lag in steps.
            batch_size: first dimension of the data.
            device: device of the data.
        """
        self._history_length = max(0, history_length)
        self._ring = CircularBuffer(self._history_length + 1, batch_size, device)
        self._time_lags = torch.zeros(batch_size, dtype=torch.int, device=device)

    @property
    def batch_size(self) -> int:
        """First dimension of the data."""
        return self._ring.batch_size

    @property
    def device(self) -> torch.device | str:
        """Device of the data."""
        return self._ring.device

    @property
    def history_length(self) -> int:
        """Greatest lag possible."""
        return self._history_length

    @property
    def min_time_lag(self) -> int:
        """Least lag of all entries."""
        return int(self._time_lags.min())

    @property
    def max_time_lag(self) -> int:
        """Greatest lag of all entries."""
        return int(self._time_lags.max())

    @property
    def time_lags(self) -> torch.Tensor:
        """Lag of each entry in steps. Shape is (batch_size,)."""
        return self._time_lags

    def set_time_lag(self, time_lag: int | torch.Tensor, batch_ids: Sequence[int] | torch.Tensor | None = None) -> None:
        """Set the lag of some batch entries (None: all).

        Args:
            time_lag: lag in steps, one for all or one for each of ``batch_ids``.
            batch_ids: the entries.

        Raises:
            TypeError: the lag is not an integer.
            ValueError: a lag is negative or greater than :attr:`history_length`.
        """
        if isinstance(time_lag, torch.Tensor):
            if time_lag.dtype not in (torch.int, torch.long):
                raise TypeError(f"DelayBuffer: time_lag must be int32 or int64, got {time_lag.dtype}")
            least, greatest = (int(time_lag.min()), int(time_lag.max())) if time_lag.numel() else (0, 0)
            time_lag = time_lag.to(self._time_lags)
        elif isinstance(time_lag, int):
            least = greatest = time_lag
        else:
            raise TypeError(f"DelayBuffer: time_lag must be an int or an integer tensor, got {type(time_lag).__name__}")
        if least < 0 or greatest > self._history_length:
            raise ValueError(
                f"DelayBuffer: time_lag must be between 0 and the history length {self._history_length}, got "
                f"{least if least < 0 else greatest}"
            )
        self._time_lags[slice(None) if batch_ids is None else batch_ids] = time_lag

    def reset(self, batch_ids: Sequence[int] | torch.Tensor | None = None) -> None:
        """Forget the values of some batch entries (None: all); lags stay."""
        self._ring.reset(batch_ids)

    def fill(self, data: torch.Tensor, batch_ids: Sequence[int] | torch.Tensor) -> None:
        """Put in the first values of some batch entries, shape (len(batch_ids), ...), and leave the others alone."""
        self._ring.fill(data, batch_ids)

    def compute(self, data: torch.Tensor) -> torch.Tensor:
        """Put in the latest values and return the delayed ones. Shapes are (batch_size, ...)."""
        self._ring.append(data)
        return self._ring[self._time_lags]
