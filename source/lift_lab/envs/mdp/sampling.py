"""Uniform samples from ranges of a configuration.

A range becomes tensors once per distinct value, so that a curriculum may still change it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import torch

from lift_lab.utils.errors import ConfigError, suggest

POSE_AXES = ("x", "y", "z", "roll", "pitch", "yaw")
"""Keys of a range dictionary over position and Euler angles, or linear and angular velocity."""


@lru_cache(maxsize=1024)
def _bounds(ranges: tuple[tuple[float, float], ...], device: str) -> tuple[torch.Tensor, torch.Tensor]:
    low = torch.tensor([r[0] for r in ranges], dtype=torch.float32, device=device)
    high = torch.tensor([r[1] for r in ranges], dtype=torch.float32, device=device)
    return low, high - low


def range_limits(ranges: Sequence[Sequence[float]], device: str) -> tuple[torch.Tensor, torch.Tensor]:
    """Lower and upper ends of (low, high) ranges, each of shape (len(ranges),)."""
    low, span = _bounds(tuple((float(low), float(high)) for low, high in ranges), str(device))
    return low, low + span


def sample_ranges(ranges: Sequence[Sequence[float]], count: int, device: str) -> torch.Tensor:
    """Uniform samples, one column for each (low, high) range.

    Returns:
        Shape (count, len(ranges)), float32.
    """
    low, span = _bounds(tuple((float(low), float(high)) for low, high in ranges), str(device))
    return torch.addcmul(low, torch.rand(count, len(low), device=device), span)


def axis_ranges(
    ranges: Mapping[str, Sequence[float]], what: str, axes: Sequence[str] = POSE_AXES
) -> list[Sequence[float]]:
    """Ranges of a dictionary in the order of ``axes``; an axis that is not named stays at zero.

    Raises:
        ConfigError: the dictionary names an axis that does not exist.
    """
    for name in ranges:
        if name not in axes:
            raise ConfigError(f"{what}: there is no axis '{name}': {suggest(name, axes)}")
    return [ranges.get(axis, (0.0, 0.0)) for axis in axes]


def is_zero(ranges: Sequence[Sequence[float]]) -> bool:
    """Whether every range is (0, 0), so that nothing needs to be sampled."""
    return all(low == 0.0 and high == 0.0 for low, high in ranges)
