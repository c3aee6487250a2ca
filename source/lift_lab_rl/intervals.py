"""Confidence intervals: Wilson's for a success rate, Student's t for a mean over seeds, Welch's for a difference."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import NormalDist

import numpy as np


def wilson_interval(successes: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Interval of the rate behind ``successes`` of ``trials`` (Wilson 1927, without continuity correction).

    Args:
        successes: trials that succeeded.
        trials: all trials, at least 1.
        confidence: share of such intervals that contain the rate.

    Returns:
        Lower and upper end, within [0, 1].
    """
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    rate = successes / trials
    centre = rate + z * z / (2 * trials)
    half = z * math.sqrt(rate * (1 - rate) / trials + (z / (2 * trials)) ** 2)
    scale = 1 + z * z / trials
    return max(0.0, (centre - half) / scale), min(1.0, (centre + half) / scale)


def t_interval(values: Sequence[float], confidence: float = 0.95) -> tuple[float, float] | None:
    """Student's t interval of the mean behind ``values``, taken as normally distributed.

    Args:
        values: one value for each seed.
        confidence: share of such intervals that contain the mean.

    Returns:
        Lower and upper end; None for fewer than two values, which have no spread.
    """
    if len(values) < 2:
        return None
    return _around(float(np.mean(values)), _squared_error(values), len(values) - 1, confidence)


def welch_interval(
    first: Sequence[float], second: Sequence[float], confidence: float = 0.95
) -> tuple[float, float] | None:
    """Welch's interval of the mean behind ``second`` minus the mean behind ``first``, which are independent.

    Returns:
        Lower and upper end; None if either has fewer than two values.
    """
    if min(len(first), len(second)) < 2:
        return None
    parts = [(_squared_error(values), len(values) - 1) for values in (first, second)]
    total = sum(error for error, _ in parts)
    dof = total**2 / sum(error**2 / freedom for error, freedom in parts) if total > 0.0 else 1.0
    return _around(float(np.mean(second) - np.mean(first)), total, dof, confidence)


def t_quantile(confidence: float, dof: float) -> float:
    """Within how many standard errors of the mean the share ``confidence`` of Student's t distribution lies.

    With t = sqrt(dof) tan(angle), the density of the angle is proportional to cos(angle) to the power of dof - 1.

    Args:
        confidence: share, in (0, 1).
        dof: degrees of freedom, at least 1.
    """
    angles = np.linspace(0.0, math.pi / 2, 200_001)
    density = np.cos(angles[:-1] + angles[1] / 2) ** (dof - 1.0)
    shares = np.concatenate(([0.0], np.cumsum(density) / density.sum()))
    return math.sqrt(dof) * math.tan(np.interp(confidence, shares, angles))


def _squared_error(values: Sequence[float]) -> float:
    """Squared standard error of the mean."""
    return float(np.var(values, ddof=1)) / len(values)


def _around(middle: float, squared_error: float, dof: float, confidence: float) -> tuple[float, float]:
    half = t_quantile(confidence, dof) * math.sqrt(squared_error)
    return middle - half, middle + half
