"""Schedules follow their formulas."""

import pytest

from lift_lab_rl.rsl_rl.schedules import LinearSchedule, adapted_rate


def test_a_linear_schedule_stands_still_before_and_after_its_span():
    schedule = LinearSchedule(0.9, 0.98, 1, 3)
    assert [schedule.value(k) for k in range(5)] == pytest.approx([0.9, 0.9, 0.94, 0.98, 0.98])


def test_a_span_of_no_length_is_a_jump():
    schedule = LinearSchedule(1.0, 0.0, 2, 2)
    assert [schedule.value(k) for k in range(4)] == [1.0, 1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("rate", "kl", "expected"),
    [
        (1e-3, 0.021, 1e-3 / 1.5),
        (1e-3, 0.019, 1e-3),
        (1e-3, 0.0051, 1e-3),
        (1e-3, 0.0049, 1.5e-3),
        (1e-3, 0.0, 1e-3),
        (1.2e-5, 1.0, 1e-5),
        (9e-3, 0.001, 1e-2),
    ],
)
def test_the_learning_rate_follows_the_divergence_within_its_bounds(rate, kl, expected):
    assert adapted_rate(rate, kl, 0.01) == pytest.approx(expected)
