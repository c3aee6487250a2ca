"""Schedules of the training: linear schedules of settings, and the adaptive learning rate."""

from __future__ import annotations

from dataclasses import dataclass

MIN_RATE, MAX_RATE = 1e-5, 1e-2
"""Bounds of the adaptive learning rate (rsl_rl's)."""


@dataclass(frozen=True)
class LinearSchedule:
    """A setting that goes linearly from one value to another between two iterations."""

    initial: float
    """Value before ``start``."""
    final: float
    """Value from ``end`` on."""
    start: int
    """First iteration of the change."""
    end: int
    """Iteration that has the final value first."""

    def value(self, iteration: int) -> float:
        """The value in an iteration.

        Args:
            iteration: iterations finished before it, counted from where schedules begin; -1 before that.
        """
        span = max(1, self.end - self.start)
        share = 1.0 if iteration >= self.end else max(0, iteration - self.start) / span
        return self.initial + (self.final - self.initial) * share


def adapted_rate(rate: float, kl: float, desired_kl: float) -> float:
    """Learning rate that keeps the divergence of an update near ``desired_kl``, by rsl_rl's rule.

    Args:
        rate: present learning rate.
        kl: divergence between the new and the old policy.
        desired_kl: its target; the rate does not change within a factor of 2.
    """
    if kl > desired_kl * 2.0:
        return max(MIN_RATE, rate / 1.5)
    if 0.0 < kl < desired_kl / 2.0:
        return min(MAX_RATE, rate * 1.5)
    return rate
