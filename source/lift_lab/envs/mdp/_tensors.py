"""Indexing and sampling shared by the terms, kept to as few tensor operations as possible.

Lists of joint and body indices become device tensors once (a list would be converted, on a GPU even copied, at every
call), and sampling ranges become tensors once per distinct range, so that a curriculum may still change them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

import torch

from lift_lab.utils.errors import ConfigError, suggest

Index = slice | Sequence[int] | torch.Tensor
"""Columns of an asset's tensors: ``slice(None)`` for all, or indices."""

EnvIds = torch.Tensor | Sequence[int] | slice | None
"""Some environments: a LongTensor, a list or a slice; None means all."""

POSE_AXES = ("x", "y", "z", "roll", "pitch", "yaw")
"""Keys of a range dictionary over position and Euler angles, or linear and angular velocity."""

_ALL = slice(None)


@lru_cache(maxsize=1024)
def _index_tensor(ids: tuple[int, ...], device: torch.device) -> torch.Tensor:
    return torch.tensor(ids, dtype=torch.long, device=device)


def columns(values: torch.Tensor, ids: Index) -> torch.Tensor:
    """``values[:, ids]``, as a view where ``ids`` is a slice.

    Args:
        values: shape (num_envs, n, ...).
        ids: indices into the second dimension.
    """
    if isinstance(ids, slice):
        return values if ids == _ALL else values[:, ids]
    if not isinstance(ids, torch.Tensor):
        ids = _index_tensor(tuple(ids), values.device)
    return values.index_select(1, ids)


def block(values: torch.Tensor, env_ids: EnvIds, ids: Index = _ALL) -> torch.Tensor:
    """A copy of ``values[env_ids][:, ids]``; None stands for all environments."""
    rows = values if env_ids is None else values[env_ids]
    picked = columns(rows, ids)
    shared = isinstance(ids, slice) and (env_ids is None or isinstance(env_ids, slice))
    return picked.clone() if shared else picked


def num_rows(env_ids: EnvIds, num_envs: int) -> int:
    """How many environments ``env_ids`` names."""
    if env_ids is None:
        return num_envs
    return len(range(*env_ids.indices(num_envs))) if isinstance(env_ids, slice) else len(env_ids)


def compact_index(ids: Sequence[int], size: int, device: str | torch.device) -> slice | torch.Tensor:
    """The cheapest index equal to ``ids``: a slice when they are consecutive, else a tensor.

    Args:
        ids: indices, in the order wanted.
        size: how many there are in all; the full set in order becomes ``slice(None)``.
        device: where a tensor index lives.
    """
    ids = list(ids)
    if ids == list(range(size)):
        return _ALL
    if ids and ids == list(range(ids[0], ids[0] + len(ids))):
        return slice(ids[0], ids[0] + len(ids))
    return _index_tensor(tuple(ids), torch.device(device))


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
