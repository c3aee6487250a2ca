"""Confidence intervals: Wilson's for a success rate, the bootstrap's for a mean over seeds."""

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


def bootstrap_interval(
    values: Sequence[float], confidence: float = 0.95, resamples: int = 10_000, seed: int = 0
) -> tuple[float, float] | None:
    """Percentile-bootstrap interval of the mean.

    Args:
        values: one value for each seed.
        confidence: share of the resampled means inside.
        resamples: how many means are drawn.
        seed: of the draws, so that a report repeats.

    Returns:
        Lower and upper end; None for fewer than two values, which tell nothing of their spread.
    """
    if len(values) < 2:
        return None
    means = _resampled_means(np.asarray(values, float), resamples, np.random.default_rng(seed))
    return _percentiles(means, confidence)


def bootstrap_difference(
    first: Sequence[float],
    second: Sequence[float],
    confidence: float = 0.95,
    resamples: int = 10_000,
    seed: int = 0,
) -> tuple[float, float] | None:
    """Percentile-bootstrap interval of the mean of ``second`` minus the mean of ``first``, resampled independently.

    Returns:
        Lower and upper end; None if either has fewer than two values.
    """
    if min(len(first), len(second)) < 2:
        return None
    rng = np.random.default_rng(seed)
    low = _resampled_means(np.asarray(first, float), resamples, rng)
    high = _resampled_means(np.asarray(second, float), resamples, rng)
    return _percentiles(high - low, confidence)


def _resampled_means(values: np.ndarray, resamples: int, rng: np.random.Generator) -> np.ndarray:
    return values[rng.integers(0, len(values), (resamples, len(values)))].mean(1)


def _percentiles(means: np.ndarray, confidence: float) -> tuple[float, float]:
    low, high = np.quantile(means, [(1 - confidence) / 2, (1 + confidence) / 2])
    return float(low), float(high)
