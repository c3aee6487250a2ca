"""Functions that threads run side by side: TorchScript runs its operations without Python's interpreter lock."""

from __future__ import annotations

import functools
import threading
import warnings
from collections.abc import Callable
from typing import Any, TypeVar

import torch

Function = TypeVar("Function", bound=Callable[..., Any])

_COMPILING = threading.Lock()


def compiled(function: Function) -> Function:
    """A function of tensors as TorchScript, compiled at its first call in some hundredths of a second.

    It runs the same operations in the same order, so no bit of a result changes.

    Args:
        function: written in TorchScript's part of Python, with annotated arguments.
    """

    @functools.cache
    def script() -> Any:
        with warnings.catch_warnings():
            # torch names torch.compile instead. It fuses operations, which changes bits, and needs a C++ compiler.
            for category in (DeprecationWarning, FutureWarning):
                warnings.filterwarnings("ignore", message=r".*torch\.jit\.script.*deprecated", category=category)
            return torch.jit.script(function)

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        with _COMPILING:
            run = script()
        return run(*args, **kwargs)

    return call  # type: ignore[return-value]
