"""Conversion of arguments of environments: no configuration, and actions that are no tensors."""

from __future__ import annotations

import importlib
from typing import Any

import gymnasium
import numpy as np
import torch

from lift_lab.utils.errors import ConfigError, suggest


def new_cfg(entry: Any) -> Any:
    """Return a new configuration from a task's ``env_cfg_entry_point``.

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


def config_of_arguments(
    cfg: Any, num_envs: int | None, device: str | None, registered: dict[str, Any], observation_group: bool = False
) -> Any:
    """The configuration that the arguments of ``gym.make`` ask for.

    Args:
        cfg: the configuration; None for a new one of ``env_cfg_entry_point``. It is not changed.
        num_envs: number of environments; None for the configuration's.
        device: torch device; None for the configuration's.
        registered: further arguments. Those are valid that a task was registered with.
        observation_group: whether the environment has that argument, for the error.

    Raises:
        ConfigError: there is no configuration, or an argument is unknown.
    """
    entry = registered.get("env_cfg_entry_point")
    for name in registered:
        if not name.endswith("_entry_point") and not _is_registered(name, entry):
            known = ["cfg", "num_envs", "device", "render_mode", *(["observation_group"] if observation_group else [])]
            raise ConfigError(f"unknown argument '{name}' of an environment: {suggest(name, known)}")
    if cfg is None:
        cfg = new_cfg(entry)
    elif num_envs is not None or device is not None:
        cfg = cfg.copy()
    if num_envs is not None:
        cfg.scene.num_envs = num_envs
    if device is not None:
        cfg.sim.device = device
    return cfg


def _is_registered(name: str, entry: Any) -> bool:
    """Whether a task of this configuration was registered with an argument of this name."""
    specs = [spec.kwargs for spec in gymnasium.registry.values() if entry is not None]
    return any(name in kwargs and kwargs.get("env_cfg_entry_point") == entry for kwargs in specs)


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
