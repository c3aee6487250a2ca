"""Modifiers: scale, clip, bias, digital filter, integrator."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

from .modifier_base import ModifierBase

if TYPE_CHECKING:
    from . import modifier_cfg


def scale(data: torch.Tensor, multiplier: float) -> torch.Tensor:
    """Data times ``multiplier``."""
    return data * multiplier


def clip(data: torch.Tensor, bounds: tuple[float | None, float | None]) -> torch.Tensor:
    """Data clamped to ``bounds``; a bound of None does not bind."""
    lower, upper = bounds
    return data if lower is None and upper is None else data.clip(min=lower, max=upper)


def bias(data: torch.Tensor, value: float) -> torch.Tensor:
    """Data plus ``value``."""
    return data + value


class DigitalFilter(ModifierBase):
    r"""Linear digital filter with zero initial conditions.

    .. math:: y_i = \sum_{j=0}^{N} b_j x_{i-j} - \sum_{j=1}^{M} a_j y_{i-j}

    For example: a delay of one step is ``A=[0], B=[0, 1]``; the mean of three is ``A=[0], B=[1/3, 1/3, 1/3]``; a
    first-order low-pass filter is ``A=[-alpha], B=[1 - alpha]``.
    """

    _cfg: modifier_cfg.DigitalFilterCfg

    def __init__(self, cfg: modifier_cfg.DigitalFilterCfg, data_dim: tuple[int, ...], device: torch.device | str):
        super().__init__(cfg, data_dim, device)
        if cfg.A is None or cfg.B is None:
            raise ValueError("DigitalFilterCfg: the coefficients A and B must be set")
        self.A = torch.tensor(cfg.A, dtype=torch.float32, device=device)
        self.B = torch.tensor(cfg.B, dtype=torch.float32, device=device)
        self.x_n = torch.zeros(*self._data_dim, len(self.B), device=device)
        self.y_n = torch.zeros(*self._data_dim, len(self.A), device=device)

    def reset(self, env_ids: Sequence[int] | torch.Tensor | None = None) -> None:
        """Zero the history of some environments (None: all)."""
        ids = slice(None) if env_ids is None else env_ids
        self.x_n[ids] = 0.0
        self.y_n[ids] = 0.0

    def __call__(self, data: torch.Tensor) -> torch.Tensor:
        """Filtered data, of the same shape."""
        self.x_n = self.x_n.roll(1, dims=-1)
        self.x_n[..., 0] = data
        filtered = self.x_n @ self.B - self.y_n @ self.A
        self.y_n = self.y_n.roll(1, dims=-1)
        self.y_n[..., 0] = filtered
        return filtered


class Integrator(ModifierBase):
    """Integral over time since the reset by the trapezoidal rule, with a value of zero before the first call."""

    _cfg: modifier_cfg.IntegratorCfg

    def __init__(self, cfg: modifier_cfg.IntegratorCfg, data_dim: tuple[int, ...], device: torch.device | str):
        super().__init__(cfg, data_dim, device)
        self.integral = torch.zeros(self._data_dim, device=device)
        self.y_prev = torch.zeros(self._data_dim, device=device)

    def reset(self, env_ids: Sequence[int] | torch.Tensor | None = None) -> None:
        """Zero the integral of some environments (None: all)."""
        ids = slice(None) if env_ids is None else env_ids
        self.integral[ids] = 0.0
        self.y_prev[ids] = 0.0

    def __call__(self, data: torch.Tensor) -> torch.Tensor:
        """Integral of the data, of the same shape."""
        self.integral += 0.5 * (data + self.y_prev) * self._cfg.dt
        self.y_prev[:] = data
        return self.integral.clone()
