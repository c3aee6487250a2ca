"""Random tensors from torch's default generator of the device."""

from __future__ import annotations

import torch

from .rotations import quat_from_euler_xyz

Device = torch.device | str
Size = int | tuple[int, ...]


def default_orientation(num: int, device: Device) -> torch.Tensor:
    """Identity quaternions (w, x, y, z). Shape is (num, 4)."""
    quat = torch.zeros(num, 4, device=device)
    quat[:, 0] = 1.0
    return quat


def random_orientation(num: int, device: Device) -> torch.Tensor:
    """Quaternions (w, x, y, z) of uniformly distributed rotations. Shape is (num, 4)."""
    return torch.nn.functional.normalize(torch.randn(num, 4, device=device), dim=-1)


def random_yaw_orientation(num: int, device: Device) -> torch.Tensor:
    """Quaternions (w, x, y, z) of uniformly distributed rotations about z. Shape is (num, 4)."""
    zero = torch.zeros(num, device=device)
    return quat_from_euler_xyz(zero, zero, 2.0 * torch.pi * torch.rand(num, device=device))


def sample_uniform(
    lower: torch.Tensor | float, upper: torch.Tensor | float, size: Size, device: Device
) -> torch.Tensor:
    """Uniform samples in [lower, upper).

    Args:
        lower: lower bound; a tensor broadcasts against ``size``.
        upper: upper bound; a tensor broadcasts against ``size``.
        size: shape of the result.
        device: device of the result.
    """
    return torch.rand(size, device=device) * (upper - lower) + lower


def sample_log_uniform(
    lower: torch.Tensor | float, upper: torch.Tensor | float, size: Size, device: Device
) -> torch.Tensor:
    """Samples whose logarithm is uniform between those of the (positive) bounds. See :func:`sample_uniform`."""
    bounds = [torch.as_tensor(bound, dtype=torch.float32, device=device) for bound in (lower, upper)]
    return torch.exp(sample_uniform(torch.log(bounds[0]), torch.log(bounds[1]), size, device))


def sample_triangle(lower: float, upper: float, size: Size, device: Device) -> torch.Tensor:
    """Samples between the bounds with the density that Isaac Lab calls triangular: zero at the middle, rising linearly
    to both bounds. See :func:`sample_uniform`."""
    r = 2.0 * torch.rand(size, device=device) - 1.0
    return 0.5 * (upper - lower) * (torch.sign(r) * torch.sqrt(torch.abs(r)) + 1.0) + lower


def sample_gaussian(mean: torch.Tensor | float, std: torch.Tensor | float, size: Size, device: Device) -> torch.Tensor:
    """Normally distributed samples; tensors for ``mean`` and ``std`` broadcast against ``size``."""
    return torch.randn(size, device=device) * std + mean


def sample_cylinder(radius: float, h_range: tuple[float, float], size: Size, device: Device) -> torch.Tensor:
    """Points on the shell of a cylinder about the z axis.

    Args:
        radius: radius of the cylinder.
        h_range: least and greatest z.
        size: shape of the batch of points.
        device: device of the result.

    Returns:
        Points. Shape is (*size, 3).
    """
    angle = sample_uniform(-torch.pi, torch.pi, size, device)
    height = sample_uniform(h_range[0], h_range[1], size, device)
    return torch.stack((radius * torch.cos(angle), radius * torch.sin(angle), height), dim=-1)
