"""The best policy of a training so far: by smoothed success first and smoothed reward second.

With evaluations during the training, by their success first and their error or reward second.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from lift_lab.utils.errors import FileError
from lift_lab_rl.scalar_names import SUCCESS_RATE

from .progress import IterationReport

BEST = "model_best.pt"
"""File of the best policy."""

BEST_EVERY = 10
"""Iterations between two rankings."""


class BestPolicy:
    """Ranks the policies of a training.

    Attributes:
        rank: smoothed success and reward of the best policy; None before the first ranking.
        evaluated: the same of the best evaluation; None before the first. From then on only evaluations count.
    """

    def __init__(self, success_metric: str | None = None):
        """Rank no policy yet.

        Args:
            success_metric: log key of success; None takes ``Metrics/success_rate``, or without it the first whose last
                part starts with "success".
        """
        self.rank: tuple[float, float] | None = None
        self.evaluated: tuple[float, float] | None = None
        self._metric = success_metric
        self._smoothed: dict[str, float] = {}

    @property
    def smoothed_success(self) -> float | None:
        """Success rate of the training's episodes, smoothed over iterations; None while it is not known."""
        return self._smoothed.get("success")

    def observe(self, report: IterationReport) -> None:
        """Find an iteration's success rate and smooth it; ``report`` gets it here."""
        report.success = self.success(report.terms)
        self.smooth(report)

    def update(self, report: IterationReport, save: Callable[[], None] | None) -> None:
        """Save the policy if there never was a better one.

        Args:
            report: an iteration, after :meth:`observe`.
            save: writes the policy; None for a process or a run that writes nothing.
        """
        before = self.rank
        if save is None or not self.is_new(report.iteration) or self.evaluated is not None:
            return
        if not _saved(save):
            self.rank = before  # the next policy that is better than what is on the disk is written

    def update_evaluated(self, rank: tuple[float, float], save: Callable[[], None] | None) -> None:
        """Save the policy if there never was a better evaluation.

        Args:
            rank: success and reward (or minus the error) of the policy in an evaluation.
            save: writes the policy; None for a process or a run that writes nothing.
        """
        before = self.evaluated
        if before is not None and rank <= before:
            return
        self.evaluated = rank
        if save is not None and not _saved(save):
            self.evaluated = before

    def success(self, terms: dict[str, float]) -> float | None:
        """The success rate among an iteration's logs."""
        if self._metric is not None:
            return terms.get(self._metric)
        if SUCCESS_RATE in terms:
            return terms[SUCCESS_RATE]
        return next((value for key, value in terms.items() if key.rpartition("/")[2].startswith("success")), None)

    def smooth(self, report: IterationReport) -> None:
        """Add an iteration to the smoothed success and reward."""
        for name, value in (("success", report.success), ("reward", report.mean_reward)):
            if value is not None:
                before = self._smoothed.get(name, value)
                self._smoothed[name] = 0.8 * before + 0.2 * value

    def is_new(self, iteration: int) -> bool:
        """Whether the policy is the best so far; if so, later ones are compared with it.

        Args:
            iteration: iterations finished; every :data:`BEST_EVERY`-th is ranked.
        """
        if "reward" not in self._smoothed or iteration % BEST_EVERY:
            return False
        # Success in steps of a hundredth: below that, reward decides.
        rank = (round(self._smoothed.get("success", 0.0), 2), self._smoothed["reward"])
        if self.rank is not None and rank <= self.rank:
            return False
        self.rank = rank
        return True

    def state_dict(self) -> dict[str, Any]:
        """Return the state on which :meth:`is_new` depends, as plain values."""
        evaluated = {} if self.evaluated is None else {"best_evaluated": list(self.evaluated)}
        return {"best": None if self.rank is None else list(self.rank), "smoothed": dict(self._smoothed), **evaluated}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Continue from a state that holds the entries of :meth:`state_dict`."""
        self.rank = None if state["best"] is None else tuple(state["best"])
        self.evaluated = tuple(state["best_evaluated"]) if "best_evaluated" in state else None
        self._smoothed = dict(state["smoothed"])


def _saved(save: Callable[[], None]) -> bool:
    """Whether a policy could be written; warns if not."""
    try:
        save()
    except FileError as error:
        print(f"warning: {error}; it is tried again with the next better policy", file=sys.stderr)
        return False
    return True
