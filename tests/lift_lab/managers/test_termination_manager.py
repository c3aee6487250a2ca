"""Terminations: time outs and terminal states, and which term ended the last episode."""

import pytest
import torch

from lift_lab.managers import ManagerTermBase, TerminationManager, TerminationTermCfg


def ids_of(env, name):
    mask = torch.zeros(env.num_envs, dtype=torch.bool)
    mask[getattr(env, name)] = True
    return mask


@pytest.fixture
def manager(env):
    """A time out and two failures, which fire for the environments listed in env.late, env.fell and env.broke."""
    env.late, env.fell, env.broke = [], [], []
    return TerminationManager(
        {
            "late": TerminationTermCfg(func=ids_of, time_out=True, params={"name": "late"}),
            "fell": TerminationTermCfg(func=ids_of, params={"name": "fell"}),
            "broke": TerminationTermCfg(func=ids_of, params={"name": "broke"}),
        },
        env,
    )


def test_time_outs_and_terminal_states_are_told_apart(env, manager):
    env.late, env.fell, env.broke = [0, 1], [1, 2], [2]
    dones = manager.compute()
    assert manager.time_outs.tolist() == [True, True, False, False]
    assert manager.terminated.tolist() == [False, True, True, False]
    assert dones.tolist() == manager.dones.tolist() == [True, True, True, False]
    assert manager.get_term("broke").tolist() == [False, False, True, False]


def test_before_the_first_step_nothing_is_done(manager):
    for flags in (manager.dones, manager.time_outs, manager.terminated):
        assert flags.tolist() == [False] * 4


def test_the_log_counts_all_environments_by_how_their_last_episode_ended(env, manager):
    env.late, env.fell = [0], [1]
    manager.compute()
    log = manager.reset([0, 1])
    assert {k: v.item() for k, v in log.items()} == {
        "Episode_Termination/late": 0.25,
        "Episode_Termination/fell": 0.25,
        "Episode_Termination/broke": 0.0,
    }
    # a step in which nothing ends keeps the account
    env.late, env.fell = [], []
    manager.compute()
    assert manager.reset([])["Episode_Termination/late"].item() == 0.25
    # the next end of environment 0 replaces its entry
    env.fell = [0, 3]
    manager.compute()
    log = manager.reset([0, 3])
    assert log["Episode_Termination/late"].item() == 0.0
    assert log["Episode_Termination/fell"].item() == 0.75
    assert log["Episode_Termination/fell"].shape == ()


def test_flags_handed_out_are_not_overwritten_by_the_next_step(env, manager):
    env.late, env.fell = [0], [1]
    dones, time_outs, terminated = manager.compute(), manager.time_outs, manager.terminated
    env.late, env.fell = [2], [3]
    manager.compute()
    assert time_outs.tolist() == [True, False, False, False]
    assert terminated.tolist() == [False, True, False, False]
    assert dones.tolist() == [True, True, False, False]


def test_a_term_that_becomes_a_time_out_counts_as_one(env, manager):
    env.fell = [3]
    manager.get_term_cfg("fell").time_out = True
    manager.compute()
    assert manager.time_outs.tolist() == [False, False, False, True]
    assert not manager.terminated.any()


def test_class_terms_are_reset(env):
    class Patience(ManagerTermBase):
        def __init__(self, cfg, env):
            super().__init__(cfg, env)
            self.steps = torch.zeros(self.num_envs)

        def reset(self, env_ids=None):
            self.steps[env_ids] = 0

        def __call__(self, env):
            self.steps += 1
            return self.steps >= 2

    manager = TerminationManager({"patience": TerminationTermCfg(func=Patience)}, env)
    manager.compute()
    manager.reset([0])
    assert manager.compute().tolist() == [False, True, True, True]
    manager.reset()
    assert manager.compute().tolist() == [False] * 4


def test_a_term_of_another_shape_or_type_is_named(env):
    with pytest.raises(ValueError, match=r"'bad' returned shape \(4, 1\)"):
        TerminationManager({"bad": TerminationTermCfg(func=lambda env: torch.zeros(4, 1))}, env).compute()
    with pytest.raises(TypeError, match=r"'bad' returned torch.float32, expected torch.bool"):
        TerminationManager({"bad": TerminationTermCfg(func=lambda env: torch.zeros(4))}, env).compute()


def test_without_terms_no_episode_ends(env):
    manager = TerminationManager(None, env)
    assert not manager.compute().any()
    assert manager.reset() == {}


def test_an_unknown_term_is_reported_with_the_closest_name(manager):
    with pytest.raises(ValueError, match="did you mean 'broke'"):
        manager.get_term("broken")


def test_viewers_and_tables_show_every_term(env, manager):
    env.fell = [1]
    manager.compute()
    assert manager.get_active_iterable_terms(1) == [("late", [0.0]), ("fell", [1.0]), ("broke", [0.0])]
    assert "| 0     | late  | True     |" in str(manager)
