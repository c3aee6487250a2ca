"""Files that are either whole or not there: written beside their place, synced, then moved into it."""

from __future__ import annotations

import contextlib
import os
import re
import socket
import time
from pathlib import Path

from ..errors import FileError

_HOST = re.sub(r"\W", "-", socket.gethostname().partition(".")[0])[:32]
_TEMPORARY = re.compile(r"\..+\.(?:(?P<host>[\w-]+)-)?(?P<pid>\d+)\.tmp(\.\w+)?", re.ASCII)

FOREIGN_S = 24 * 3600.0
"""Temporary files of processes that this machine cannot ask after are kept as long, in s."""


def temporary_path(path: Path) -> Path:
    """Return the path to which this process writes a file before it is moved to ``path``. The name contains the process
    id."""
    return path.with_name(f".{path.name}.{_HOST}-{os.getpid()}.tmp")


def write_atomically(path: str | Path, data: bytes) -> None:
    """Write ``data`` to ``path`` so that a crash at any moment leaves the old file or the new one.

    Args:
        path: where to; its folder is made.
        data: content.

    Raises:
        FileError: it cannot be written.
    """
    path = Path(path)
    temporary = temporary_path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(temporary, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
        _sync_folder(path.parent)
    except OSError as error:
        _remove(temporary)
        raise FileError(f"cannot write '{path}': {error.strerror or error}") from error
    except BaseException:
        _remove(temporary)
        raise


def remove_dead_temporaries(folder: str | Path, depth: int = 3) -> list[Path]:
    """Remove the half-written files of processes that were killed.

    Those of another machine, whose processes cannot be asked after, are removed after :data:`FOREIGN_S`.

    Args:
        folder: where to look.
        depth: how many folders below it are looked into.

    Returns:
        What was removed.
    """
    removed = []
    for place, folders, names in os.walk(folder):
        if len(Path(place).relative_to(folder).parts) >= depth:
            folders.clear()
        for name in names:
            found = _TEMPORARY.fullmatch(name)
            path = Path(place) / name
            if found is not None and _is_dead(path, found["host"], int(found["pid"])) and _remove(path):
                removed.append(path)
    return removed


def _is_dead(path: Path, host: str | None, pid: int) -> bool:
    if host != _HOST:
        try:
            return time.time() - path.stat().st_mtime > FOREIGN_S
        except OSError:
            return False
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except OverflowError:
        return True
    except OSError:  # of another user
        return False
    return False


def _remove(temporary: Path) -> bool:
    with contextlib.suppress(OSError):
        temporary.unlink()
        return True
    return False


def _sync_folder(folder: Path) -> None:
    """Make a rename survive a power cut, where the system can."""
    if os.name != "posix":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
