"""Steps and resets in and out of torch's inference mode, in any order.

Tensors made in inference mode cannot be written to outside of it, and an environment writes to its buffers for ever.
"""

from __future__ import annotations

import functools
import weakref
from collections.abc import Callable
from typing import Any, Concatenate, ParamSpec, TypeVar

import torch

_Env = TypeVar("_Env")
_Args = ParamSpec("_Args")
_Result = TypeVar("_Result")

_MET_INFERENCE_MODE: weakref.WeakSet[Any] = weakref.WeakSet()
"""Environments that were called in inference mode. Kept here: it is no part of an environment's state."""


def in_any_grad_mode(
    method: Callable[Concatenate[_Env, _Args], _Result],
) -> Callable[Concatenate[_Env, _Args], _Result]:
    """Let a method of an environment be called in and out of inference mode.

    Once it has been called inside, calls from outside also run in inference mode. They return copies with which
    gradients may be computed.
    """

    @functools.wraps(method)
    def wrapper(self: _Env, *args: _Args.args, **kwargs: _Args.kwargs) -> _Result:
        if torch.is_inference_mode_enabled():
            _MET_INFERENCE_MODE.add(self)
        elif self in _MET_INFERENCE_MODE:
            with torch.inference_mode():
                result = method(self, *args, **kwargs)
            return _copied(result)
        return method(self, *args, **kwargs)

    return wrapper


def _copied(value: Any) -> Any:
    """Tensors in tuples and dictionaries copied; everything else as it is."""
    if isinstance(value, torch.Tensor):
        return value.clone()
    if isinstance(value, dict):
        return {key: _copied(entry) for key, entry in value.items()}
    return tuple(_copied(entry) for entry in value) if type(value) is tuple else value
