"""Arrays of numpy and torch, and conversion of either (or of anything array-like) to torch."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

TensorData = np.ndarray | torch.Tensor
"""An array of either library."""

TENSOR_TYPES: dict[str, type] = {"numpy": np.ndarray, "torch": torch.Tensor}
"""Name of a library -> its array type."""

TENSOR_TYPE_CONVERSIONS: dict[str, dict[type, Any]] = {
    "numpy": {torch.Tensor: lambda x: x.detach().cpu().numpy()},
    "torch": {np.ndarray: torch.from_numpy},
}
"""Name of the target library -> {array type of the source: conversion}."""


def convert_to_torch(
    array: Any, dtype: torch.dtype | None = None, device: torch.device | str | None = None
) -> torch.Tensor:
    """Convert an array to a torch tensor, sharing memory where possible.

    Args:
        array: a tensor, a numpy array, a number or (nested) sequence, or an array that offers
            ``__cuda_array_interface__`` or ``__array_interface__``.
        dtype: type of the result. None keeps the array's; numbers and sequences become float32.
        device: device of the result. None keeps the array's.
    """
    if isinstance(array, torch.Tensor):
        tensor = array
    elif isinstance(array, np.ndarray):
        # torch has few operations on unsigned types
        signed = {"u2": np.int16, "u4": np.int32, "u8": np.int64}.get(array.dtype.str[1:])
        tensor = torch.from_numpy(array if signed is None else array.astype(signed))
    elif hasattr(array, "__cuda_array_interface__") or hasattr(array, "__array_interface__"):
        tensor = torch.as_tensor(array)
    else:
        tensor = torch.as_tensor(array, dtype=dtype or torch.float32)
    return tensor.to(device=device, dtype=dtype)
