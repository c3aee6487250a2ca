"""Intervals of shares, means and differences are those of scipy and of the tables."""

import numpy as np
import pytest
from scipy import stats
from scipy.stats import binomtest

from lift_lab_rl.intervals import t_interval, t_quantile, welch_interval, wilson_interval


@pytest.mark.parametrize(("wins", "trials"), [(0, 10), (10, 10), (48, 50), (99, 100), (995, 1000)])
def test_wilson_intervals_are_scipys(wins, trials):
    expected = binomtest(wins, trials).proportion_ci(0.95, method="wilson")
    assert wilson_interval(wins, trials) == pytest.approx((expected.low, expected.high), abs=1e-9)


@pytest.mark.parametrize(("dof", "expected"), [(1, 12.706), (2, 4.303), (4, 2.776), (9, 2.262), (1e6, 1.960)])
def test_quantiles_of_students_t_are_those_of_the_tables(dof, expected):
    assert t_quantile(0.95, dof) == pytest.approx(expected, abs=5e-4)


def test_intervals_of_means_and_differences_are_scipys():
    first, second = [2.5, 2.85, 3.14], [3.09, 3.33, 3.49, 3.6]
    low, high = stats.t.interval(0.95, 2, loc=np.mean(first), scale=stats.sem(first))
    assert t_interval(first) == pytest.approx((low, high), rel=1e-6)
    welch = stats.ttest_ind(second, first, equal_var=False).confidence_interval(0.95)
    assert welch_interval(first, second) == pytest.approx((welch.low, welch.high), rel=1e-6)
    assert t_interval([3.0]) is welch_interval([1.0], [3.0, 3.0]) is None
    assert t_interval([3.0, 3.0]) == (3.0, 3.0)
    assert welch_interval([1.0, 1.0], [3.0, 3.0]) == (2.0, 2.0)


def test_an_interval_over_three_seeds_holds_the_mean_as_often_as_it_says():
    draws = np.random.default_rng(1).normal(5.0, 2.0, (1000, 3))
    ends = np.array([t_interval(list(values)) for values in draws])
    # the binomial's deviation is 0.7 points
    assert np.mean((ends[:, 0] < 5.0) & (ends[:, 1] > 5.0)) == pytest.approx(0.95, abs=0.021)
