"""The best policy is the one with the most success, then with the most reward, both smoothed."""

from types import SimpleNamespace

import pytest

from lift_lab_rl.rsl_rl.best_policy import BestPolicy


def report(iteration, success, reward):
    return SimpleNamespace(iteration=iteration, success=success, mean_reward=reward)


def looks(best, reports):
    """For each report in turn whether the policy was the best so far."""
    found = []
    for one in reports:
        best.smooth(one)
        found.append(best.is_new(one.iteration))
    return found


def test_success_comes_first_and_reward_decides_within_a_hundredth_of_it():
    def alone(success, reward):
        """A policy whose numbers are not smoothed with those before."""
        other = BestPolicy()
        other.rank = best.rank
        other.smooth(report(10, success, reward))
        new = other.is_new(10)
        best.rank = other.rank
        return new

    best = BestPolicy()
    given = [(0.1, 5.0), (0.1, 4.0), (0.101, 4.9), (0.101, 5.1), (0.9, 1.0), (0.5, 9.0), (None, 99.0)]
    assert [alone(*pair) for pair in given] == [True, False, False, True, True, False, False]


def test_a_fifth_of_each_new_number_is_taken_in():
    best = BestPolicy()
    assert looks(best, [report(9, 0.0, 1.0), report(10, 1.0, 6.0)]) == [False, True]
    assert best.rank == pytest.approx((0.2, 2.0))


def test_there_is_a_look_at_every_tenth_iteration_only_and_none_without_a_finished_episode():
    best = BestPolicy()
    reports = [report(10, 0.5, None), report(11, 0.5, 1.0), report(19, 0.5, 2.0), report(20, 0.5, 3.0)]
    assert looks(best, reports) == [False, False, False, True]


def test_success_is_the_log_that_is_named_else_the_first_that_is_called_so():
    terms = {"Episode_Reward/lifted": 3.0, "Metrics/success_rate": 0.4, "Metrics/grasped": 0.7, "success": 0.1}
    assert BestPolicy().success(terms) == 0.4
    assert BestPolicy("Metrics/grasped").success(terms) == 0.7
    assert BestPolicy("Metrics/other").success(terms) is None
    assert BestPolicy().success({"Episode_Reward/lifted": 3.0}) is None


def test_a_loaded_state_goes_on_as_if_it_had_never_stopped():
    before = [report(k, 0.01 * k, 1.0 - 0.002 * k) for k in range(1, 40)]
    after = [report(k, 0.2 + 0.5 * (k % 20 == 0), 0.5) for k in range(40, 90)]
    whole, first, rest = BestPolicy(), BestPolicy(), BestPolicy()
    looks(whole, before)
    looks(first, before)
    rest.load_state_dict(first.state_dict())
    assert looks(rest, after) == looks(whole, after)
    assert rest.state_dict() == whole.state_dict()
    assert BestPolicy().state_dict() == {"best": None, "smoothed": {}}
