"""Files that are either whole or not there: written beside their place, synced, then moved into it."""

from __future__ import annotations

import io
import json
import os
import sys
import warnings
from pathlib import Path
from typing import Any

import torch

from lift_lab.utils.errors import FileError
from lift_lab.utils.io import write_atomically

from .digest import add_digest, damage


def check_target(path: str | Path) -> None:
    """Check that a file can be written, before the work that it is for; makes its folder.

    Raises:
        FileError: it cannot be written.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"cannot write '{path}': {error.strerror}: '{error.filename}'") from error
    if path.is_dir():
        raise FileError(f"cannot write '{path}': it is a folder")
    if not os.access(path.parent, os.W_OK):
        raise FileError(f"cannot write '{path}': its folder is read-only")


def read_json(path: str | Path) -> Any:
    """Content of a JSON file.

    Raises:
        FileError: there is none, or it is not JSON.
    """
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise FileError(f"cannot read '{path}': {error.strerror}") from error
    except ValueError as error:
        raise FileError(f"cannot read '{path}': it is not JSON: {error}") from error


def save_torch(path: str | Path, content: Any) -> None:
    """Write tensors and plain values to a torch file, atomically and with a digest.

    Equal content gives equal bytes for every name of the file. ``torch.load`` reads the file, too.
    """
    buffer = io.BytesIO()
    torch.save(content, buffer)
    write_atomically(path, add_digest(buffer.getvalue()))


def load_torch(path: str | Path, map_location: str | None = "cpu") -> Any:
    """Read a file of tensors and plain values; code in it is not run.

    Args:
        path: the file. One without a digest is read, too.
        map_location: device of the tensors.

    Returns:
        What the file holds.

    Raises:
        FileError: there is no such file, it is damaged, or it is no file of tensors and plain values.
    """
    if not Path(path).is_file():
        raise FileError(f"no file '{path}'")
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise FileError(f"cannot read '{path}': {error.strerror or error}") from error
    problem = damage(data)
    if problem is not None:
        raise FileError(f"cannot read '{path}': {problem}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of TorchScript, which ends in an error anyway
            return torch.load(io.BytesIO(data), map_location=map_location, weights_only=True)
    except Exception as error:  # of a file that is something else, anything can be wrong
        raise FileError(f"cannot read '{path}': it is no checkpoint (model_N.pt), or not a whole one") from error


def canonical(value: Any) -> Any:
    """The same content in new containers, so that equal content gives equal bytes whatever its history."""
    if isinstance(value, torch.Tensor):
        return value.detach().clone()
    if isinstance(value, dict):
        return {(sys.intern(key) if isinstance(key, str) else key): canonical(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(canonical(entry) for entry in value)
    return value
