"""Saving of checkpoints during training, also on a full or failing disk."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

from lift_lab.app import endings
from lift_lab.utils.errors import FileError
from lift_lab_rl import distributed

LAST_TRIES_S = (1.0, 2.0, 4.0, 8.0, 15.0, 30.0)
"""Waits between attempts to write a training's last checkpoint, in s."""

STOPPED_TRIES = 3
"""Number of these waits after a user's signal: whoever stops a training does not want to wait for long."""


class CheckpointSaver:
    """Saves every so many iterations, again after each iteration while that fails, and at the end.

    With several processes, all have to call it alike; if one of them cannot write, all try again.
    """

    def __init__(self, save: Callable[[], None], interval: int, speaks: bool = True):
        """Save nothing yet.

        Args:
            save: writes a checkpoint of the present; raises FileError if it cannot.
            interval: iterations between two checkpoints.
            speaks: whether warnings are printed.
        """
        self._save, self._interval, self._speaks = save, interval, speaks
        self.problem: str | None = None
        """Why the newest checkpoint that was due is not written; None if it is."""

    def after_iteration(self, done: int, total: int, stopped_by: int | None) -> bool:
        """Save if it is time.

        Args:
            done: iterations finished.
            total: iterations to do.
            stopped_by: signal that the training is to end for; None if it is not.

        Returns:
            Whether the training may end now. Nobody waits for a training that ends because its terminal or its output
            is lost: it goes on until a checkpoint is written.

        Raises:
            FileError: the last checkpoint cannot be written, also after several attempts.
        """
        if done < total and stopped_by in (None, endings.HANGUP):
            if stopped_by is not None or done % self._interval == 0 or self.problem is not None:
                self._try()
            return self.problem is None
        waits = LAST_TRIES_S if done == total else LAST_TRIES_S[:STOPPED_TRIES]
        for wait in waits:
            if self._try():
                return True
            time.sleep(wait)
        if not self._try():
            raise FileError(f"{self.problem} (after iteration {done}, tried for {sum(waits):.0f} s)")
        return True

    def _try(self) -> bool:
        problem = None
        try:
            self._save()
        except FileError as error:
            problem = str(error)
        problem = distributed.first_problem(problem)
        if problem is not None and self.problem is None:
            self._say(f"warning: {problem}; trying again after each iteration")
        elif problem is None and self.problem is not None:
            self._say("checkpoints are written again")
        self.problem = problem
        return problem is None

    def _say(self, text: str) -> None:
        if self._speaks:
            print(text, file=sys.stderr)
