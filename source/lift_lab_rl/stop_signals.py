"""Ctrl-C, SIGTERM and a lost terminal while training: the first ends the run after the running iteration.

A second Ctrl-C or SIGTERM ends it at once. A second SIGHUP does not: a terminal that is closed may send it several
times. SIGHUP also stands for output that cannot be written.
"""

from __future__ import annotations

import contextlib
import signal
import sys
import time
from collections.abc import Callable, Iterator
from types import FrameType

from lift_lab.app import endings

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

        SIGHUP stays ignored where it is, as under ``nohup``.

        Args:
            say: shows a line to the user; None for standard error.
        """

        def stop(number: int, _: FrameType | None) -> None:
            first = self._own
            if first is not None and endings.HANGUP in (first, number):
                if number != endings.HANGUP:
                    self._own, self._own_at = number, time.monotonic()
                return
            if first is not None:
                # torchrun passes a signal on that the terminal has sent to every process already
                if self._place.is_distributed and time.monotonic() < self._own_at + REPEATED_S:
                    return
                raise endings.Interrupted(number)
            self._own, self._own_at = number, time.monotonic()
            if not self._place.is_main:
                return
            name = signal.Signals(number).name
            if number == endings.HANGUP:
                print(f"{name} or lost output: finishing this iteration, then saving", file=sys.stderr)
                return
            text = f"{name}: finishing this iteration, then saving (again to end at once)"
            if say is not None:
                say(text)
            else:
                print(text, file=sys.stderr)

        with endings.handled(stop):
            yield

    def agree(self) -> int | None:
        """Exchange signals with the other processes; waits for all of them.

        Returns:
            The signal that ends all processes after the current iteration; None to continue.
        """
        number = distributed.stop_number(self._own)
        if number is not None and self._own is None:
            self._own, self._own_at = number, time.monotonic()
        return number
