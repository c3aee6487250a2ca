"""What environments take besides their own types: no configuration, and actions that are no tensors."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
import torch

from lift_lab.utils.errors import ConfigError


def new_cfg(entry: Any) -> Any:
    """A new configuration of what a task was registered with under ``env_cfg_entry_point``.

    Args:
        entry: ``"module:Class"``, a class, a function or an instance; None if there is none.

    Raises:
        ConfigError: there is none.
    """
    if entry is None:
        raise ConfigError("no config: pass cfg, or register the task with 'env_cfg_entry_point'")
    if isinstance(entry, str):
        module, _, name = entry.partition(":")
        entry = getattr(importlib.import_module(module), name)
    return entry() if callable(entry) else entry.copy()


def action_tensor(action: Any, device: str) -> torch.Tensor:
    """An action as a tensor on a device.

    Args:
        action: a tensor, an array, or a list of numbers.
        device: torch device.

    Raises:
        ConfigError: anything else.
    """
    if isinstance(action, torch.Tensor):
        return action.detach().to(device)
    try:
        numbers = np.asarray(action)
    except (TypeError, ValueError):  # rows of different lengths
        numbers = np.asarray(None)
    if numbers.dtype.kind not in "fiub":  # numpy would turn None into NaN
        kind, text = type(action).__name__, " ".join(str(action).split())[:60]
        raise ConfigError(f"an action is a tensor, an array or a list of numbers, not {kind} {text}")
    return torch.as_tensor(numbers, dtype=torch.float32, device=device)
