"""Ctrl-C and SIGTERM while training: the first ends the run after the running iteration, a second one at once."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import FrameType

from . import distributed

REPEATED_S = 3.0
"""With several processes: a second signal within this time, in s, is the first one again."""


class StopSignals:
    """The signals that come to the processes of one training."""

    def __init__(self, place: distributed.Place):
        """Catch nothing yet.

        Args:
            place: this process's place among those of the training.
        """
        self._place = place
        self._own: int | None = None  # signal that came to this process
        self._own_at = 0.0

    @contextlib.contextmanager
    def caught(self, say: Callable[[str], None] | None = None) -> Iterator[None]:
        """Keep signals from ending the process at once. Does nothing outside the main thread, which alone gets them.

        Args:
            say: shows a line to the user; None for standard error.
        """
        if threading.current_thread() is not threading.main_thread():
            yield
            return

        def stop(number: int, _: FrameType | None) -> None:
            if self._own is not None:
                # torchrun passes a signal on that the terminal has sent to every process already
                if self._place.is_distributed and time.monotonic() < self._own_at + REPEATED_S:
                    return
                raise KeyboardInterrupt
            self._own, self._own_at = number, time.monotonic()
            if not self._place.is_main:
                return
            text = f"{signal.Signals(number).name}: finishing this iteration, then saving (again to end at once)"
            if say is not None:
                say(text)
            else:
                print(text, file=sys.stderr)

        before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
        try:
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    def agree(self) -> bool:
        """Tell the other processes of this one's signal and learn of theirs; waits for all of them.

        Returns:
            Whether all end after the iteration that they have just done.
        """
        number = distributed.stop_number(self._own)
        if number is not None and self._own is None:
            self._own, self._own_at = number, time.monotonic()
        return number is not None
