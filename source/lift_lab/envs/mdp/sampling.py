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


def sample_offsets_outside(
    ranges: Mapping[str, Sequence[float]], factor: float, like: torch.Tensor, what: str
) -> torch.Tensor:
    """Offsets along x, y and z outside their ranges, uniform within the ranges ``factor`` times as wide.

    Args:
        ranges: (low, high) for any axis.
        factor: above 1.
        like: a tensor with one row for each offset, on the device of the result.
        what: how messages call the ranges.

    Returns:
        Shape (n, 3).

    Raises:
        ConfigError: no range of x, y and z has a width.
    """
    wide = [axis for axis in "xyz" if ranges.get(axis, (0.0, 0.0))[1] > ranges.get(axis, (0.0, 0.0))[0]]
    if not wide:
        raise ConfigError(f"{what}: no range of x, y and z has a width")
    offsets = {axis: sample_axis(ranges, axis, like) for axis in "xyz"}
    unit = torch.rand(len(like), len(wide), device=like.device) * 2.0 - 1.0
    for axis, offset in zip(wide, outside_unit_box(unit, factor).unbind(1), strict=True):
        low, high = ranges[axis]
        offsets[axis] = (low + high) / 2 + offset * (high - low) / 2
    return torch.stack([offsets[axis] for axis in "xyz"], 1)


def sample_axis(ranges: Mapping[str, Sequence[float]], axis: str, like: torch.Tensor) -> torch.Tensor:
    """Uniform values of one axis, shape (n,), with n the rows of ``like``; zero if the axis has no range."""
    low, high = ranges.get(axis, (0.0, 0.0))
    return (
        torch.empty(len(like), device=like.device).uniform_(low, high)
        if high > low
        else like.new_full((len(like),), low)
    )


def outside_unit_box(points: torch.Tensor, factor: float) -> torch.Tensor:
    """Move uniform points of the box [-1, 1]^d out of it, uniformly into the rest of a box ``factor`` times as wide.

    The greatest coordinate m of a uniform point has m^d uniform in [0, 1]; outside it has to be uniform in
    [1, factor^d].

    Args:
        points: shape (n, d).
        factor: above 1.
    """
    dim = points.shape[1]
    m = points.abs().amax(1, keepdim=True).clamp(min=1e-6)
    return points / m * (1.0 + m**dim * (factor**dim - 1.0)) ** (1.0 / dim)
