"""The environment's log of several steps is averaged over the episodes behind it, with every learning library."""

import pytest
import torch

from lift_lab_rl.episode_logs import EpisodeLogs


def dones(*ended, envs=4):
    flags = torch.zeros(envs, dtype=torch.bool)
    flags[list(ended)] = True
    return flags


def test_each_step_weighs_as_many_episodes_as_ended_in_it():
    logs = EpisodeLogs()
    logs.add({"log": {"Metrics/a": torch.tensor(1.0), "Metrics/b": 1.0}}, dones(0, 1, 2))
    logs.add({"log": {"Metrics/a": torch.tensor(0.0)}}, dones(3))
    assert logs.means() == {"Metrics/a": pytest.approx(3 / 4), "Metrics/b": 1.0}
    logs.clear()
    assert logs.means() == {}


def test_an_entry_of_fewer_episodes_weighs_less():
    logs = EpisodeLogs()
    logs.add({"log": {"Metrics/time": 2.0}, "log_counts": {"Metrics/time": 1}}, dones(0, 1, 2))
    logs.add({"log": {"Metrics/time": 5.0}}, dones(0, 1))
    assert logs.means() == {"Metrics/time": pytest.approx((2.0 + 2 * 5.0) / 3)}


def test_a_log_that_is_kept_until_the_next_reset_counts_once():
    logs, log = EpisodeLogs(), {"Metrics/a": 1.0}
    logs.add({"log": log}, dones(0))
    logs.add({"log": log}, dones())
    logs.add({"log": {"Metrics/a": 3.0}}, dones(1))
    assert logs.means() == {"Metrics/a": 2.0}
    assert len(logs.entries()) == 2


def test_a_log_of_no_episode_is_left_out():
    logs = EpisodeLogs()
    logs.add({"log": {"Metrics/a": 9.0}}, dones())
    assert logs.means() == {}
    logs.add({"log": {"Metrics/a": 1.0}}, dones(2))
    assert logs.means() == {"Metrics/a": 1.0}


def test_failures_of_the_physics_are_added_up():
    logs = EpisodeLogs()
    for failed, ended in ((2.0, (0, 1, 2)), (1.0, (3,)), (0.0, (0, 1))):
        logs.add({"log": {"Metrics/physics/nonfinite": torch.tensor(failed)}}, dones(*ended))
    assert logs.means() == {"Metrics/physics/nonfinite": 3.0}
