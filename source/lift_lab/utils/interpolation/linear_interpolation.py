"""Linear interpolation of a sampled scalar function."""

from __future__ import annotations

import torch


class LinearInterpolation:
    """A scalar function given by samples; linear between them and constant beyond them."""

    def __init__(self, x: torch.Tensor, y: torch.Tensor, device: torch.device | str):
        """
        Args:
            x: where the function was sampled, ascending. Shape is (num_samples,).
            y: values there. Shape is (num_samples,).
            device: device of the computation.

        Raises:
            ValueError: no samples, different numbers of them, or ``x`` does not ascend.
        """
        self._x = x.reshape(-1).to(device=device, copy=True)
        self._y = y.reshape(-1).to(device=device, copy=True)
        if self._x.numel() == 0:
            raise ValueError("LinearInterpolation: there are no samples")
        if self._x.numel() != self._y.numel():
            raise ValueError(f"LinearInterpolation: {self._x.numel()} samples of x but {self._y.numel()} of y")
        if bool((self._x[1:] < self._x[:-1]).any()):
            raise ValueError("LinearInterpolation: x must ascend")

    def compute(self, q: torch.Tensor) -> torch.Tensor:
        """Values at the points ``q``, which may have any shape."""
        last = self._x.numel() - 1
        upper = torch.searchsorted(self._x, q.contiguous())
        lower, upper = (upper - 1).clamp(min=0), upper.clamp(max=last)
        width = self._x[upper] - self._x[lower]
        inside = width > 0
        weight = torch.where(inside, (q - self._x[lower]) / torch.where(inside, width, 1.0), 0.0)
        return torch.lerp(self._y[lower], self._y[upper], weight)
