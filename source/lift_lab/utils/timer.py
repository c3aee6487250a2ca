"""A stopwatch for code: object, context manager and decorator."""

from __future__ import annotations

import time
from contextlib import ContextDecorator
from typing import Any, ClassVar

from .errors import suggest


class TimerError(Exception):
    """A timer was used out of order."""


class Timer(ContextDecorator):
    """Measure wall-clock time.

    .. code-block:: python

        with Timer("reset took", name="reset") as timer:
            env.reset()
        Timer.get_timer_info("reset")
    """

    timing_info: ClassVar[dict[str, float]] = {}
    """Name of a timer -> its last run time in s."""

    def __init__(self, msg: str | None = None, name: str | None = None):
        """
        Args:
            msg: text printed with the time when the context ends. None prints nothing.
            name: key under which :attr:`timing_info` keeps the time. None keeps nothing.
        """
        self._msg = msg
        self._name = name
        self._start: float | None = None
        self._total: float | None = None

    def __str__(self) -> str:
        return f"{self.time_elapsed:0.6f} seconds"

    @property
    def time_elapsed(self) -> float:
        """Seconds since the start; the run time once stopped."""
        if self._start is None:
            return self.total_run_time
        return time.perf_counter() - self._start

    @property
    def total_run_time(self) -> float:
        """Seconds between start and stop."""
        if self._total is None:
            raise TimerError("the timer has not run; call start() and stop()")
        return self._total

    def start(self) -> None:
        """Start measuring."""
        if self._start is not None:
            raise TimerError("the timer is running; call stop() first")
        self._start = time.perf_counter()

    def stop(self) -> None:
        """Stop measuring."""
        if self._start is None:
            raise TimerError("the timer is not running; call start() first")
        self._total = time.perf_counter() - self._start
        self._start = None
        if self._name is not None:
            Timer.timing_info[self._name] = self._total

    def __enter__(self) -> Timer:
        self.start()
        return self

    def __exit__(self, *exc_info: Any) -> None:
        self.stop()
        if self._msg is not None:
            print(f"{self._msg}: {self.total_run_time:0.6f} seconds")

    @staticmethod
    def get_timer_info(name: str) -> float:
        """Last run time in s of the timer of that name.

        Raises:
            TimerError: no such timer.
        """
        if name not in Timer.timing_info:
            raise TimerError(f"no timer '{name}'; {suggest(name, Timer.timing_info)}")
        return Timer.timing_info[name]
