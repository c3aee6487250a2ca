"""Steps in real time: ``play --real-time``."""

from __future__ import annotations

import time
from collections.abc import Callable

CATCH_UP_S = 0.1
"""A simulation that is further behind the clock forgets the rest: it does not run faster than real time for long."""


class Pace:
    """Keeps a simulation from running ahead of the clock, and knows whether it kept up."""

    def __init__(
        self,
        step_s: float,
        clock: Callable[[], float] = time.perf_counter,
        sleep: Callable[[float], None] = time.sleep,
    ):
        """Start now.

        Args:
            step_s: simulated time of a step in s.
            clock: the time in s.
            sleep: waits for some seconds.
        """
        self.step_s, self.steps, self.late = step_s, 0, 0
        self._clock, self._sleep = clock, sleep
        self._start = self._due = clock()

    def wait(self) -> None:
        """After a step: wait until the clock has come as far as the simulation."""
        self.steps += 1
        self._due += self.step_s
        now = self._clock()
        if now < self._due:
            self._sleep(self._due - now)
            return
        self.late += 1
        self._due = max(self._due, now - CATCH_UP_S)

    def summary(self) -> str:
        """One line: simulated time, time taken, and whether the simulation was too slow."""
        simulated, taken = self.steps * self.step_s, self._clock() - self._start
        text = f"real time: {simulated:.2f} s of simulation in {taken:.2f} s"
        if taken <= simulated + CATCH_UP_S:
            return text
        return f"{text}: too slow in {self.late} of {self.steps} steps; try fewer environments (--num_envs)"
