"""Signals that end a script early: Ctrl-C, SIGTERM, and SIGHUP, which reports that the terminal was closed.

All three raise :class:`Interrupted` in the main thread, so files and environments are closed. A training installs its
own handlers while it runs.
"""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType

HANGUP = int(getattr(signal, "SIGHUP", 1))
"""Number of the signal for a lost terminal. A script whose output cannot be written sends it to itself."""

STOPPING = tuple(int(number) for number in (signal.SIGINT, signal.SIGTERM, getattr(signal, "SIGHUP", None)) if number)
"""Signals that ask a process to end."""


class Interrupted(KeyboardInterrupt):
    """A signal asks the process to end.

    Attributes:
        number: of the signal.
    """

    def __init__(self, number: int):
        super().__init__(signal.Signals(number).name)
        self.number = number


def exit_status(number: int) -> int:
    """Exit status of a process that ends because of a signal: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
    return 128 + number


def number_of(interrupt: KeyboardInterrupt) -> int:
    """The signal that an exception is of; SIGINT for Python's own."""
    return interrupt.number if isinstance(interrupt, Interrupted) else int(signal.SIGINT)


def is_ignored(number: int) -> bool:
    """Whether the process was started so that it ignores a signal, as ``nohup`` does with SIGHUP."""
    return signal.getsignal(number) is signal.SIG_IGN


_REPEATED = 0.5
"""Signals that follow another one within this time in s are one with it: a key that is held down, a shell that sends to
a process and to its group. Raising again would interrupt what deals with the first."""


class _Raise:
    """A handler that raises; not for a SIGHUP that follows another signal: that process ends already."""

    def __init__(self) -> None:
        self._last: float | None = None

    def __call__(self, number: int, _: FrameType | None) -> None:
        last, self._last = self._last, time.monotonic()
        if last is not None and (number == HANGUP or self._last - last < _REPEATED):
            return
        raise Interrupted(number)


@contextlib.contextmanager
def handled(handler: Callable[[int, FrameType | None], None] | None = None) -> Iterator[None]:
    """Handle the signals that ask this process to end; not SIGHUP where it is ignored.

    Does nothing outside the main thread, which alone gets signals.

    Args:
        handler: gets the number of the signal and the frame; None raises :class:`Interrupted`.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [number for number in STOPPING if number != HANGUP or not is_ignored(number)]
    handler = handler or _Raise()
    before = {number: signal.signal(number, handler) for number in numbers}
    try:
        yield
    finally:
        for number, old in before.items():
            if signal.getsignal(number) is handler:  # not after ignore()
                signal.signal(number, old if old is not None else signal.SIG_DFL)


def ignore() -> None:
    """Ignore further signals: this process is about to end."""
    if threading.current_thread() is threading.main_thread():
        for number in STOPPING:
            signal.signal(number, signal.SIG_IGN)


def hang_up() -> None:
    """Send SIGHUP to this process if it handles it."""
    if hasattr(signal, "SIGHUP") and callable(signal.getsignal(HANGUP)):
        os.kill(os.getpid(), HANGUP)
