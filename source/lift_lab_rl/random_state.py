"""The state of the global random numbers, for a run that is continued."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import torch


def rng_state() -> dict[str, Any]:
    """State of torch's, numpy's and Python's global random numbers."""
    name, keys, position, has_gauss, gauss = np.random.get_state()  # noqa: NPY002 - the global generator is meant
    version, numbers, gauss_next = random.getstate()
    state: dict[str, Any] = {
        "torch": torch.get_rng_state(),
        "numpy": [str(name), torch.from_numpy(np.asarray(keys, np.int64)), int(position), int(has_gauss), float(gauss)],
        "python": [version, torch.tensor(numbers, dtype=torch.int64), gauss_next],
    }
    if torch.cuda.is_available():
        state["cuda"] = torch.cuda.get_rng_state_all()
    return state


def check_rng_state(state: dict[str, Any]) -> None:
    """Check that a state can be written back; touches no generator in use.

    Raises:
        Exception: of torch, numpy or Python; the state is none of :func:`rng_state`.
    """
    torch.Generator().set_state(state["torch"])
    name, keys, position, has_gauss, gauss = state["numpy"]
    np.random.RandomState().set_state((name, keys.numpy().astype(np.uint32), position, has_gauss, gauss))
    version, numbers, gauss_next = state["python"]
    random.Random().setstate((version, tuple(numbers.tolist()), gauss_next))
    for values in state.get("cuda", ()):
        if not isinstance(values, torch.Tensor) or values.dtype != torch.uint8:
            raise TypeError("the state of a GPU's random numbers has to be a tensor of bytes")


def load_rng_state(state: dict[str, Any]) -> None:
    """Write a state of :func:`rng_state` back."""
    torch.set_rng_state(state["torch"])
    name, keys, position, has_gauss, gauss = state["numpy"]
    np.random.set_state((name, keys.numpy().astype(np.uint32), position, has_gauss, gauss))  # noqa: NPY002
    version, numbers, gauss_next = state["python"]
    random.setstate((version, tuple(numbers.tolist()), gauss_next))
    if "cuda" in state and torch.cuda.is_available() and len(state["cuda"]) == torch.cuda.device_count():
        torch.cuda.set_rng_state_all(state["cuda"])
