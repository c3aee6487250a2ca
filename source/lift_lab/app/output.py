"""Standard output and standard error that may go away while a script runs.

A terminal may be closed, the reader of a pipe may end, or a disk may be full. After the first text that cannot be
written, the stream leads to the null device. This holds for Python, C code and child processes, so printing ends none
of them. The script then continues as after SIGHUP: see :mod:`lift_lab.app.endings`.
"""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any, TextIO

from . import endings


class Output:
    """A text stream that never raises. Everything but writing is the stream's own."""

    def __init__(self, stream: TextIO, name: str):
        """Wrap a stream.

        Args:
            stream: where text goes.
            name: of the stream, for the user.
        """
        self._stream = stream
        self._name = name
        self.problem: str | None = None
        """Why text is not written any more; None while it is."""
        self.reader_ended = False
        """Whether the reader of a pipe ended, as ``head`` does on purpose."""
        self.is_in_use = True
        """Whether the script still runs; a logger may keep a stream for longer."""

    def write(self, text: str) -> int:
        """Write text, or forget it; returns its length."""
        try:
            self._stream.write(text)
        except UnicodeEncodeError:
            encoding = self._stream.encoding or "ascii"
            return self.write(text.encode(encoding, "backslashreplace").decode(encoding))
        except (OSError, ValueError, RuntimeError) as error:
            self._note(error, text)
        return len(text)

    def writelines(self, lines: Any) -> None:
        """Write several texts."""
        for line in lines:
            self.write(line)

    def flush(self) -> None:
        """Write buffered text, or drop it if it cannot be written."""
        try:
            self._stream.flush()
        except (OSError, ValueError, RuntimeError) as error:
            self._note(error)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def _note(self, error: Exception, text: str = "") -> None:
        if isinstance(error, BlockingIOError):  # a reader that is too slow for a pipe that does not wait
            return
        if isinstance(error, RuntimeError):  # a signal's handler printed while its thread was printing
            with contextlib.suppress(OSError, ValueError):
                os.write(self._stream.fileno(), text.encode(errors="replace"))
            return
        if self.problem is None:
            self.problem = f"{self._name} is lost ({getattr(error, 'strerror', None) or error})"
            self.reader_ended = isinstance(error, BrokenPipeError)
            self._lead_nowhere()
            if self.is_in_use:
                endings.hang_up()

    def _lead_nowhere(self) -> None:
        null = os.open(os.devnull, os.O_WRONLY)
        try:
            os.dup2(null, self._stream.fileno())
        except (OSError, ValueError):  # no file behind it, or closed
            self._stream = open(os.devnull, "w")  # noqa: SIM115 - as long as the process
        finally:
            os.close(null)


@contextlib.contextmanager
def guarded() -> Iterator[tuple[Output, Output]]:
    """Let :data:`sys.stdout` and :data:`sys.stderr` be streams that never raise.

    A stream that was closed before the script began leads to the null device from the beginning, which is no loss.
    """
    _open_closed()
    before = sys.stdout, sys.stderr
    streams = Output(before[0], "standard output"), Output(before[1], "standard error")
    sys.stdout, sys.stderr = streams
    try:
        yield streams
    finally:
        for stream in streams:
            stream.flush()
            stream.is_in_use = False
        sys.stdout, sys.stderr = before


def _open_closed() -> None:
    """Keep a file that is opened later from getting the number of a standard stream, and so the text for it."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # gets the lowest free number: this one
        if getattr(sys, name) is None:
            mode = "r" if number == 0 else "w"
            setattr(sys, name, open(number, mode, closefd=False, errors="backslashreplace"))  # noqa: SIM115
