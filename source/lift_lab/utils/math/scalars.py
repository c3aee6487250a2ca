"""Element-wise helpers: scaling to ranges, clamping, wrapping angles."""

from __future__ import annotations

import torch


def scale_transform(x: torch.Tensor, lower: torch.Tensor, upper: torch.Tensor) -> torch.Tensor:
    """Map the range [lower, upper] to [-1, 1]. Shapes broadcast, e.g. (N, D) with (D,)."""
    return (2.0 * x - (lower + upper)) / (upper - lower)


def unscale_transform(x: torch.Tensor, lower: torch.Tensor, upper: torch.Tensor) -> torch.Tensor:
    """Map the range [-1, 1] to [lower, upper]. Shapes broadcast, e.g. (N, D) with (D,)."""
    return 0.5 * (x * (upper - lower) + (lower + upper))


def saturate(x: torch.Tensor, lower: torch.Tensor, upper: torch.Tensor) -> torch.Tensor:
    """Clamp to [lower, upper]. Shapes broadcast, e.g. (N, D) with (D,)."""
    return torch.clamp(x, min=lower, max=upper)


def normalize(x: torch.Tensor, eps: float = 1e-9) -> torch.Tensor:
    """Scale vectors (last dimension) to unit length; shorter than ``eps``, they are divided by ``eps``."""
    return x / torch.linalg.vector_norm(x, dim=-1, keepdim=True).clamp(min=eps)


def wrap_to_pi(angles: torch.Tensor) -> torch.Tensor:
    """Wrap angles in rad to [-pi, pi]; odd multiples of pi keep their sign (as MATLAB's ``wrapToPi``)."""
    wrapped = torch.remainder(angles + torch.pi, 2 * torch.pi)
    return torch.where((wrapped == 0) & (angles > 0), torch.pi, wrapped - torch.pi)


def copysign(mag: float, other: torch.Tensor) -> torch.Tensor:
    """A tensor of the shape of ``other`` that has magnitude ``|mag|`` and the sign of ``other``."""
    return torch.copysign(torch.full_like(other, abs(mag)), other)
