"""Warnings that MuJoCo itself prints, as a few lines of the log.

MuJoCo counts most warnings for each simulation, and :meth:`Physics.health` reports them. It only prints some of them,
to the console and to ``MUJOCO_LOG.TXT``, at each solver iteration of each simulation. An example is "Linesearch
objective is not convex" where a state diverges.
"""

from __future__ import annotations

import logging
import re
import threading

import mujoco

_LOG = logging.getLogger(__name__)
_NUMBER = re.compile(r"\d+(\.\d+)?(e[+-]?\d+)?")


class WarningThrottle:
    """Log a warning when it comes for the first, the 10th, the 100th, ... time; texts may differ in their numbers.

    MuJoCo calls it from any of its threads.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: dict[str, int] = {}

    def __call__(self, text: str) -> None:
        """Count a warning and log it if it is due; never raises, since the caller is C code."""
        try:
            with self._lock:
                kind = _NUMBER.sub("#", text)
                count = self._counts[kind] = self._counts.get(kind, 0) + 1
            if count == 1:
                _LOG.warning("MuJoCo: %s", text)
            elif count == 10 ** (len(str(count)) - 1):
                _LOG.warning("MuJoCo: %s (%s times so far)", text, f"{count:,}")
        except Exception:  # an exception in C code would end the process
            pass


_THROTTLE = WarningThrottle()


def throttle_engine_warnings() -> None:
    """Send MuJoCo's own warnings to the log for the whole process; a handler that is already set stays."""
    if mujoco.get_mju_user_warning() is None:
        mujoco.set_mju_user_warning(_THROTTLE)
