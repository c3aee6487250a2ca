"""Scripts that a script starts: they end with it, also if it is killed.

The kernel sends a child SIGTERM when its parent is gone. The child asks for this in :func:`follow_parent`, then checks
that the parent is still there. So a killed parent never leaves a child behind. On systems without ``prctl`` only
:class:`FolderLock` protects.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
import time
from pathlib import Path

from . import endings

_PARENT = "LIFT_LAB_PARENT"
"""Variable by which a child knows its parent's process number."""

_PR_SET_PDEATHSIG = 1

PATIENCE_S = 60.0
"""Time in s that a start waits for the last processes of an earlier one."""


def child_environment() -> dict[str, str]:
    """Environment of a child that is to end with this process; the child's main goes through ``cli.run``."""
    return os.environ | {_PARENT: str(os.getpid())}


def follow_parent() -> None:
    """Have this process end with its parent, if the parent asked for it in :func:`child_environment`."""
    parent = os.environ.pop(_PARENT, None)
    if parent is None or not sys.platform.startswith("linux"):
        return
    with contextlib.suppress(OSError, AttributeError):
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, int(signal.SIGTERM), 0, 0, 0)
    if os.getppid() != int(parent):
        raise SystemExit(endings.exit_status(signal.SIGTERM))


class FolderLock:
    """A folder that one start at a time works in. Children that inherit :attr:`handle` keep it locked."""

    def __init__(self, folder: Path, owner: str):
        """Lock a folder, which is made; waits for the last processes of an earlier start.

        Args:
            folder: what to lock.
            owner: what works in it, for the user.

        Raises:
            ConfigError: another process has locked it, and keeps it.
        """
        from lift_lab.utils.errors import ConfigError, FileError

        path = folder / ".lock"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self.handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        except OSError as error:
            raise FileError(f"cannot write '{path}': {error.strerror}") from error
        end, told = time.monotonic() + PATIENCE_S, False
        while not self._take():
            process = os.pread(self.handle, 20, 0).decode(errors="replace").strip() or "?"
            if process.isdigit() and _runs(int(process)):
                os.close(self.handle)
                raise ConfigError(f"{owner} already works in '{folder}' (process {process}): wait for it, or stop it")
            if time.monotonic() > end:
                os.close(self.handle)
                raise ConfigError(f"'{folder}' is in use by a process that an earlier {owner} left: stop it first")
            if not told:
                print(f"waiting for what an earlier {owner} left to save and end", file=sys.stderr, flush=True)
                told = True
            time.sleep(0.1)
        os.ftruncate(self.handle, 0)
        os.pwrite(self.handle, f"{os.getpid()}\n".encode(), 0)

    def _take(self) -> bool:
        try:
            import fcntl
        except ImportError:  # not on this system
            return True
        try:
            fcntl.flock(self.handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError as error:
            print(f"warning: this file system has no locks ({error.strerror}): start it once only", file=sys.stderr)
        return True

    def release(self) -> None:
        """Let others in, once the children have ended."""
        os.close(self.handle)


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
