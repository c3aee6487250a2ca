"""Rows of buffers that hold one for each environment."""

from __future__ import annotations

from collections.abc import Sequence

import torch


def fill_rows(
    buffer: torch.Tensor,
    env_ids: torch.Tensor | Sequence[int] | slice | None,
    value: float | bool,
    dim: int = 0,
) -> None:
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
        buffer[(slice(None),) * dim + (slice(None) if env_ids is None else env_ids,)] = value
