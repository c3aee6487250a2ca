"""Functions that threads run side by side: TorchScript runs its operations without Python's interpreter lock."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import torch


def compiled(function: Callable[..., Any]) -> Any:
    """A function of tensors as TorchScript. It runs the same operations in the same order: no bit of a result changes.

    Args:
        function: written in TorchScript's part of Python, with annotated arguments.

    Returns:
        A callable with the same arguments.
    """
    with warnings.catch_warnings():
        # torch names torch.compile instead. It fuses operations, which changes bits, and needs a C++ compiler.
        warnings.filterwarnings("ignore", message=r".*torch\.jit\.script.*deprecated", category=DeprecationWarning)
        warnings.filterwarnings("ignore", message=r".*torch\.jit\.script.*deprecated", category=FutureWarning)
        return torch.jit.script(function)
