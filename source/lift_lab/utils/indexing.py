"""Indexing of tensors whose first dimension counts the environments, with as few tensor operations as possible.

A list of joint or body indices becomes a device tensor once. A list would be converted at every call, and on a GPU it
would be copied as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import torch

Index = slice | Sequence[int] | torch.Tensor
"""Columns of an asset's tensors: ``slice(None)`` for all, or indices."""

EnvIds = torch.Tensor | Sequence[int] | slice | None
"""Some environments: a LongTensor, a list or a slice; None means all."""

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
    """Return the number of environments that ``env_ids`` names."""
    if env_ids is None:
        return num_envs
    return len(range(*env_ids.indices(num_envs))) if isinstance(env_ids, slice) else len(env_ids)


def compact_index(ids: Sequence[int], size: int, device: str | torch.device) -> slice | torch.Tensor:
    """The cheapest index equal to ``ids``: a slice when they are consecutive, else a tensor.

    Args:
        ids: indices, in the order wanted.
        size: how many there are in all; the full set in order becomes ``slice(None)``.
        device: device of a tensor index.
    """
    ids = list(ids)
    if ids == list(range(size)):
        return _ALL
    if ids and ids == list(range(ids[0], ids[0] + len(ids))):
        return slice(ids[0], ids[0] + len(ids))
    return _index_tensor(tuple(ids), torch.device(device))


def fill_rows(buffer: torch.Tensor, env_ids: EnvIds, value: float | bool, dim: int = 0) -> None:
    """Set rows of a buffer to one value, in place: ``buffer[env_ids] = value`` at half its cost.

    Args:
        buffer: shape (num_envs, ...).
        env_ids: the rows; None means all.
        value: what every element of them becomes.
        dim: which dimension of the buffer counts the environments.
    """
    if isinstance(env_ids, torch.Tensor) and env_ids.dtype == torch.long:
        buffer.index_fill_(dim, env_ids, value)
    else:
        buffer[(_ALL,) * dim + (_ALL if env_ids is None else env_ids,)] = value


def where_true(masks: Sequence[torch.Tensor]) -> list[torch.Tensor]:
    """Return the indices where each mask is true. The host waits for the device once, not once per mask.

    Args:
        masks: bool tensors of one shape (n,) on one device.

    Returns:
        For each mask its indices, ascending, as a LongTensor on that device.
    """
    device = masks[0].device
    rows = torch.stack(list(masks)).cpu().numpy()
    return [torch.from_numpy(np.flatnonzero(row)).to(device, non_blocking=True) for row in rows]
