"""Rows and columns of a field as callers name them, checked and as tensors."""

from __future__ import annotations

from collections.abc import Iterable, Set

import torch

from lift_lab.utils.errors import ConfigError


def ids_tensor(ids: torch.Tensor | Iterable[int] | int, device: torch.device, count: int | None = None) -> torch.Tensor:
    """Environment or column numbers as a LongTensor.

    Args:
        ids: the numbers, in one dimension, or a single one.
        device: of the result.
        count: how many there are to choose from, where that is to be checked; on a GPU it is not, the host would wait.

    Raises:
        ConfigError: a mask, fractions, text, several dimensions, or a number out of range.
    """
    if not isinstance(ids, torch.Tensor):
        try:
            ids = torch.as_tensor(list(ids) if isinstance(ids, Set) else ids)
        except (TypeError, ValueError, RuntimeError) as error:
            raise ConfigError(f"ids must be integers, got {ids!r}") from error
    if ids.numel() and (ids.dtype == torch.bool or ids.is_floating_point() or ids.is_complex()):
        raise ConfigError(f"ids must be integers, not {ids.dtype}; of a mask take mask.nonzero().flatten()")
    if ids.ndim > 1:
        raise ConfigError(f"ids must have one dimension, got shape {tuple(ids.shape)}")
    if count is not None and ids.is_cpu and ids.numel():
        least, greatest = int(ids.min()), int(ids.max())
        if least < -count or greatest >= count:
            wrong = greatest if greatest >= count else least
            raise ConfigError(f"id {wrong} is out of range: there are {count}, numbered from 0")
    return ids.to(device=device, dtype=torch.long)


def broadcast_rows(name: str, values: torch.Tensor, rows: int, cols: int) -> torch.Tensor:
    """`values` expanded to (rows, cols), with an error that names the field."""
    try:
        return values.expand(rows, cols)
    except RuntimeError as error:
        shape = tuple(values.shape)
        raise ConfigError(f"cannot write '{name}': values of shape {shape} do not fit ({rows}, {cols})") from error
