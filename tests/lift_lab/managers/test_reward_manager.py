"""Rewards: value * weight * dt, sums over the episode, log entries."""

import pytest
import torch

from lift_lab.managers import RewardManager, RewardTermCfg

DT = 0.5


def index(env):
    """0, 1, 2, 3."""
    return torch.arange(env.num_envs, dtype=torch.float)


def is_even(env):
    return torch.arange(env.num_envs) % 2 == 0


def recorded(env):
    env.calls.append("called")
    return torch.full((env.num_envs,), float("nan"))


def manager_of(env, **terms):
    """A manager of terms given as name=(function, weight)."""
    return RewardManager({k: RewardTermCfg(func=f, weight=w) for k, (f, w) in terms.items()}, env)


def test_the_reward_is_the_sum_of_value_times_weight_times_dt(env):
    manager = manager_of(env, index=(index, 2.0), even=(is_even, -1.0))
    # 2 * i * 0.5 - 1 * [i even] * 0.5
    assert torch.allclose(manager.compute(DT), torch.tensor([-0.5, 1.0, 1.5, 3.0]))


def test_a_weight_of_zero_skips_the_call(env):
    manager = manager_of(env, index=(index, 2.0), costly=(recorded, 0.0))
    assert torch.allclose(manager.compute(DT), torch.tensor([0.0, 1.0, 2.0, 3.0]))
    assert env.calls == []
    assert manager.reset()["Episode_Reward/costly"] == 0.0


def test_a_weight_changed_between_steps_counts_from_the_next_step(env):
    manager = manager_of(env, index=(index, 2.0), other=(index, 0.0))
    manager.compute(DT)
    manager.get_term_cfg("index").weight = 10.0
    manager.get_term_cfg("other").weight = 1.0
    assert torch.allclose(manager.compute(DT), torch.tensor([0.0, 5.5, 11.0, 16.5]))
    # mean of i is 1.5: 1.5 * (2 + 10) * 0.5 / 5 s and 1.5 * 1 * 0.5 / 5 s
    log = manager.reset()
    assert log["Episode_Reward/index"].item() == pytest.approx(1.8)
    assert log["Episode_Reward/other"].item() == pytest.approx(0.15)


def test_another_dt_is_honoured(env):
    manager = manager_of(env, index=(index, 2.0))
    manager.compute(DT)
    assert torch.allclose(manager.compute(0.1), torch.tensor([0.0, 0.2, 0.4, 0.6]))


def test_the_log_is_the_mean_over_reset_environments_per_configured_second(env):
    manager = manager_of(env, index=(index, 2.0))
    for _ in range(3):
        manager.compute(DT)
    # environments 1 and 3: mean(1, 3) * 2 * 0.5 * 3 steps / 5 s
    log = manager.reset(torch.tensor([1, 3]))
    assert log["Episode_Reward/index"].item() == pytest.approx(1.2)
    assert log["Episode_Reward/index"].shape == ()
    # environments 0 and 2 keep their sums, 1 and 3 start anew
    assert manager.reset([0, 2])["Episode_Reward/index"].item() == pytest.approx(0.6)
    assert manager.reset()["Episode_Reward/index"].item() == 0.0


def test_the_lift_rewards_reach_185_in_an_episode(env_factory):
    env = env_factory(num_envs=2, max_episode_length_s=5.0)
    weights = {"reach": 1.0, "lift": 15.0, "goal": 16.0, "fine": 5.0}
    manager = manager_of(env, **{k: (lambda env: torch.ones(2), w) for k, w in weights.items()})
    total = sum(manager.compute(0.02) for _ in range(250))
    assert torch.allclose(total, torch.full((2,), 185.0), rtol=1e-5)
    assert manager.reset()["Episode_Reward/goal"].item() == pytest.approx(16.0, rel=1e-5)


def test_the_returned_reward_is_not_overwritten_by_the_next_step(env):
    manager = manager_of(env, index=(index, 1.0))
    first = manager.compute(1.0)
    manager.get_term_cfg("index").weight = 2.0
    manager.compute(1.0)
    assert torch.equal(first, torch.tensor([0.0, 1.0, 2.0, 3.0]))


def test_a_nan_stays_in_its_environment(env):
    def broken(env):
        return torch.tensor([0.0, float("nan"), 1.0, 1.0])

    reward = manager_of(env, index=(index, 1.0), broken=(broken, 1.0)).compute(1.0)
    assert torch.equal(reward.isnan(), torch.tensor([False, True, False, False]))


def test_a_term_may_return_a_number(env):
    assert torch.equal(manager_of(env, one=(lambda env: 1, 3.0)).compute(1.0), torch.full((4,), 3.0))


def test_a_term_of_another_shape_is_named(env):
    with pytest.raises(ValueError, match=r"term 'column' returned shape \(4, 1\), expected \(4,\)"):
        manager_of(env, column=(lambda env: torch.zeros(4, 1), 1.0)).compute(1.0)


def test_a_missing_weight_is_refused(env):
    with pytest.raises(TypeError, match="term 'index': weight must be a number"):
        RewardManager({"index": RewardTermCfg(func=index)}, env)


def test_without_terms_the_reward_is_zero(env):
    manager = RewardManager(None, env)
    assert torch.equal(manager.compute(1.0), torch.zeros(4))
    assert manager.reset() == {}


def test_viewers_get_the_weighted_value_of_each_term(env):
    manager = manager_of(env, index=(index, 2.0), even=(is_even, -1.0))
    manager.compute(DT)
    assert manager.get_active_iterable_terms(2) == [("index", [4.0]), ("even", [-1.0])]


def test_the_table_lists_every_weight(env):
    table = str(manager_of(env, index=(index, 2.0), even=(is_even, -0.0001)))
    assert "2 active terms" in table
    assert "even" in table
    assert "-0.0001" in table
