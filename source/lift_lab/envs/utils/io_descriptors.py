"""Isaac Lab's decorator of observation terms that describes them in an exported file; nothing is exported here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def generic_io_descriptor(_func: Callable[..., Any] | None = None, **description: Any) -> Any:
    """Leave the decorated term as it is; used with or without arguments.

    Args:
        _func: the term, where the decorator is used without arguments.
        **description: Isaac Lab's ``on_inspect``, ``units`` and so on.
    """
    return _func if _func is not None else lambda function: function


def _record(*args: Any, **kwargs: Any) -> None:
    """An ``on_inspect`` hook of Isaac Lab's; never called."""


record_shape = record_dtype = record_joint_names = record_body_names = _record
record_joint_pos_offsets = record_joint_vel_offsets = _record
