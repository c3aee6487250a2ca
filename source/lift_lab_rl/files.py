"""Files that are either whole or not there: written beside their place, synced, then moved into it."""

from __future__ import annotations

import io
import os
import pickle
import sys
from pathlib import Path
from typing import Any

import torch

from lift_lab.utils.errors import FileError


def write_atomically(path: str | Path, data: bytes) -> None:
    """Write ``data`` to ``path`` so that a crash at any moment leaves the old file or the new one.

    Args:
        path: where to; its folder is made.
        data: content.
    """
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        with open(temporary, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    _sync_folder(path.parent)


def _sync_folder(folder: Path) -> None:
    """Make a rename survive a power cut, where the system can."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def save_torch(path: str | Path, content: Any) -> None:
    """:func:`torch.save`, atomically. Equal content gives equal bytes, whatever the file is called."""
    buffer = io.BytesIO()
    torch.save(content, buffer)
    write_atomically(path, buffer.getvalue())


def load_torch(path: str | Path, map_location: str | None = "cpu") -> Any:
    """Read a file of tensors and plain values; code in it is not run.

    Raises:
        FileError: no such file, or not one that torch wrote.
    """
    if not Path(path).is_file():
        raise FileError(f"no file '{path}'")
    try:
        return torch.load(path, map_location=map_location, weights_only=True)
    except (RuntimeError, EOFError, OSError, ValueError, LookupError, TypeError, pickle.UnpicklingError) as error:
        reason = (str(error).strip().splitlines() or [type(error).__name__])[0]
        raise FileError(f"cannot read '{path}': {reason[:160]}") from error


def canonical(value: Any) -> Any:
    """The same content in new containers, so that equal content gives equal bytes whatever its history."""
    if isinstance(value, torch.Tensor):
        return value.detach().clone()
    if isinstance(value, dict):
        return {(sys.intern(key) if isinstance(key, str) else key): canonical(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(canonical(entry) for entry in value)
    return value
