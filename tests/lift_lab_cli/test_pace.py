"""Pacing, with a clock of the test's own."""

import pytest

from lift_lab_cli.pace import Pace


class Clock:
    def __init__(self):
        self.now, self.slept = 100.0, []

    def time(self):
        return self.now

    def sleep(self, seconds):
        self.slept.append(seconds)
        self.now += seconds


def paced(clock, durations):
    pace = Pace(0.02, clock.time, clock.sleep)
    for seconds in durations:
        clock.now += seconds
        pace.wait()
    return pace


def test_fast_steps_take_their_simulated_time():
    clock = Clock()
    pace = paced(clock, [0.005] * 50)
    assert clock.slept == pytest.approx([0.015] * 50)
    assert pace.summary() == "real time: 1.00 s of simulation in 1.00 s"


def test_a_short_delay_is_caught_up_and_a_long_one_is_not():
    clock = Clock()
    paced(clock, [0.05] + [0.0] * 10)
    assert clock.now == pytest.approx(100.0 + 11 * 0.02)
    clock = Clock()
    paced(clock, [3.0] + [0.0] * 20)
    assert clock.now == pytest.approx(103.0 - 0.1 + 20 * 0.02)


def test_a_slow_simulation_is_told():
    clock = Clock()
    text = paced(clock, [0.04] * 25).summary()
    assert clock.slept == []
    assert text.startswith("real time: 0.50 s of simulation in 1.00 s: too slow in 25 of 25 steps")
