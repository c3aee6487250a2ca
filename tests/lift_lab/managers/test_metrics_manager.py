"""Metrics: how the values of steps become one of the episode, which episodes count, and what is logged."""

from types import SimpleNamespace

import pytest
import torch

from lift_lab.managers import ManagerTermBase, MetricsManager, MetricsTermCfg
from lift_lab.utils.errors import ConfigError

NAN = float("nan")
COMMAND = SimpleNamespace(metrics={}, metrics_terms=lambda name: {})


def value(env):
    """What the test wants to be measured now."""
    return env.value


def make(env, command=COMMAND, **terms):
    env.command_manager = SimpleNamespace(active_terms=["goal"], get_term=lambda name: command)
    return MetricsManager(terms, env)


def measure(manager, *values):
    for now in values:
        manager._env.value = torch.tensor(now)
        manager.compute()


@pytest.mark.parametrize(
    ("reduce", "expected"),
    [("mean", [2.0, 1.0]), ("sum", [6.0, 3.0]), ("last", [1.0, -4.0]), ("max", [3.0, 7.0]), ("first", [2.0, 0.0])],
)
def test_the_values_of_an_episodes_steps_become_one(env_factory, reduce, expected):
    env = env_factory(num_envs=2)
    manager = make(env, term=MetricsTermCfg(func=value, reduce=reduce))
    measure(manager, [2.0, 0.0], [3.0, 7.0], [1.0, -4.0])
    assert manager.episode_value("term").tolist() == pytest.approx(expected)
    log = manager.reset(torch.tensor([0]))
    assert log.keys() == {"Metrics/term"}
    assert log["Metrics/term"].shape == ()
    assert log["Metrics/term"].item() == expected[0]
    measure(manager, [-5.0, -5.0])  # the first step of one, the fourth of the other
    old = {"mean": -0.5, "sum": -2.0, "last": -5.0, "max": 7.0, "first": 0.0}[reduce]
    assert manager.episode_value("term").tolist() == pytest.approx([-5.0, old])


def test_a_mean_without_a_name_for_the_log_is_the_default(env):
    manager = make(env, term=MetricsTermCfg(func=value))
    measure(manager, [0.0] * 4, [1.0] * 4)
    assert float(manager.reset()["Metrics/term"]) == 0.5


def test_booleans_and_whole_numbers_are_measured_too(env):
    manager = make(env, term=MetricsTermCfg(func=value, reduce="max"), other=MetricsTermCfg(func=lambda env: env.step))
    env.step = torch.tensor([1, 2, 3, 4])
    measure(manager, [True, False, False, True], [False, False, True, True])
    assert manager.episode_value("term").tolist() == [1.0, 0.0, 1.0, 1.0]
    assert manager.episode_value("other").tolist() == [1.0, 2.0, 3.0, 4.0]


def test_a_first_that_did_not_come_is_in_no_mean(env):
    manager = make(
        env,
        when=MetricsTermCfg(func=value, reduce="first", log_as="goal/when"),
        last=MetricsTermCfg(func=value, reduce="last"),
    )
    measure(manager, [NAN, 3.0, NAN, NAN], [5.0, 4.0, NAN, NAN])
    assert manager.episode_value("when")[:2].tolist() == [5.0, 3.0]
    log = manager.reset(torch.tensor([0, 1, 2]))
    assert float(log["Metrics/goal/when"]) == 4.0
    assert manager.log_counts == {"Metrics/last": 3, "Metrics/goal/when": 2}
    assert list(manager.reset(torch.tensor([3]))) == ["Metrics/last"]
    assert manager.log_counts == {"Metrics/last": 1}


@pytest.mark.parametrize("is_prefetched", [False, True])
def test_an_episode_that_is_left_out_is_in_no_mean_and_the_next_one_is(env, prefetch, is_prefetched):
    manager = make(
        env,
        last=MetricsTermCfg(func=value, reduce="last"),
        when=MetricsTermCfg(func=lambda env: torch.where(env.value > 1.5, env.value, NAN), reduce="first"),
    )
    manager.leave_out(torch.tensor([0, 1]), torch.tensor([False, True]))
    measure(manager, [1.0, 5.0, 2.0, 9.0])
    assert manager.counted_ids(None).tolist() == [0, 2, 3]
    if is_prefetched:
        prefetch(manager, 0.1, ended=torch.tensor([True, True, True, False]))
    log = manager.reset(torch.tensor([0, 1, 2]))
    assert {key: float(mean) for key, mean in log.items()} == {"Metrics/last": 1.5, "Metrics/when": 2.0}
    assert manager.log_counts == {"Metrics/last": 2, "Metrics/when": 1}
    env.prefetched = {}
    measure(manager, [1.0, 5.0, 2.0, 9.0])
    assert float(manager.reset(torch.tensor([1, 2]))["Metrics/last"]) == 3.5
    manager.leave_out(torch.tensor([3]), torch.tensor([True]))
    assert manager.reset(torch.tensor([3])) == {}
    assert manager.log_counts == {}


@pytest.mark.parametrize("reduce", ["mean", "sum", "last", "max", "first"])
def test_a_step_in_which_the_physics_failed_is_left_out(env, reduce):
    manager = make(env, term=MetricsTermCfg(func=value, reduce=reduce))
    measure(manager, [2.0] * 4)
    env.physics_failed = torch.tensor([True, False, False, False])
    measure(manager, [NAN, 4.0, 4.0, 4.0])
    assert manager.episode_value("term")[0] == 2.0
    expected = {"mean": 3.0, "sum": 6.0, "last": 4.0, "max": 4.0, "first": 2.0}[reduce]
    assert manager.episode_value("term")[1:].tolist() == [expected] * 3


class Counted(ManagerTermBase):
    """Steps since the reset."""

    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self.steps = torch.zeros(env.num_envs)

    def reset(self, env_ids=None):
        self.steps[env_ids] = 0.0

    def __call__(self, env):
        self.steps += 1.0
        return self.steps


def test_a_term_with_a_state_is_reset_with_its_episodes(env):
    manager = make(env, term=MetricsTermCfg(func=Counted, reduce="last"))
    manager.compute()
    manager.reset([1])
    manager.compute()
    assert manager.episode_value("term").tolist() == [2.0, 1.0, 2.0, 2.0]
    manager.reset()
    manager.compute()
    assert manager.episode_value("term").tolist() == [1.0] * 4


def test_a_command_brings_its_metrics_and_the_config_may_replace_them(env):
    brought = {name: MetricsTermCfg(func=value, reduce="last") for name in ("error", "angle", "own")}
    command = SimpleNamespace(metrics={"own": torch.zeros(4)}, metrics_terms=lambda name: brought)
    manager = make(env, command, mine=MetricsTermCfg(func=lambda env: -env.value, reduce="last", log_as="goal/angle"))
    measure(manager, [1.0] * 4)
    assert manager.active_terms == ["goal/error", "mine"]
    assert {k: float(v) for k, v in manager.reset().items()} == {"Metrics/goal/error": 1.0, "Metrics/goal/angle": -1.0}


@pytest.mark.parametrize(
    ("terms", "message"),
    [
        ({"up": MetricsTermCfg(func=value, reduce="averge")}, "'up': unknown reduce 'averge': choose one of: 'last'"),
        ({"up": MetricsTermCfg(func=value, reduce="maxx")}, "did you mean 'max'"),
        ({"up": MetricsTermCfg(func=value, log_as="")}, "'up': log_as must be a name such as"),
        ({"up": MetricsTermCfg(func=value, log_as="a//b")}, "not 'a//b'"),
        ({"up": MetricsTermCfg(func=value, log_as=5)}, "not 5"),
        ({"up": MetricsTermCfg(func=value, log_as="Metrics/up")}, "must not begin with 'Metrics/'"),
        ({"up": MetricsTermCfg(func=value, log_as="physics/overflow")}, "failures of the physics"),
        (
            {"up": MetricsTermCfg(func=value), "down": MetricsTermCfg(func=value, log_as="up")},
            "'down' and term 'up' are both logged as 'Metrics/up'",
        ),
        ({"up": MetricsTermCfg(func=value, log_as="goal/own")}, "the command 'goal' itself logs 'Metrics/goal/own'"),
        ({"up": MetricsTermCfg(func=value, params={"height": 1})}, "unexpected 'height'"),
    ],
)
def test_a_mistake_in_a_term_is_named(env, terms, message):
    command = SimpleNamespace(metrics={"own": torch.zeros(4)}, metrics_terms=lambda name: {})
    with pytest.raises(ConfigError, match=message):
        make(env, command, **terms)


@pytest.mark.parametrize(("now", "found"), [([[1.0]] * 4, r"shape \(4, 1\)"), ([1.0], r"shape \(1,\)")])
def test_a_value_of_another_shape_is_named(env, now, found):
    manager = make(env, term=MetricsTermCfg(func=value))
    with pytest.raises(ConfigError, match=rf"'term' returned {found}, expected a tensor of shape \(4,\)"):
        measure(manager, now)
    manager = make(env, term=MetricsTermCfg(func=lambda env: 3.0))
    with pytest.raises(ConfigError, match=r"'term' returned 3\.0"):
        manager.compute()


def test_a_terms_function_and_parameters_can_be_replaced_but_not_its_reduction(env):
    manager = make(env, a=MetricsTermCfg(func=value, reduce="last"), b=MetricsTermCfg(func=value, reduce="last"))
    manager.set_term_cfg("b", MetricsTermCfg(func=lambda env, by: by * env.value, params={"by": 2.0}, reduce="last"))
    measure(manager, [1.0] * 4)
    assert {k: float(v) for k, v in manager.reset().items()} == {"Metrics/a": 1.0, "Metrics/b": 2.0}
    with pytest.raises(ConfigError, match="reduce and log_as cannot be changed"):
        manager.set_term_cfg("b", MetricsTermCfg(func=value, reduce="max"))
    with pytest.raises(ConfigError, match=r"'c' not found: choose one of: 'a', 'b'"):
        manager.episode_value("c")


def test_nothing_is_logged_before_anything_was_measured(env):
    """As of the reset that makes an environment, or of a step of one's own that does not measure."""
    manager = make(env, term=MetricsTermCfg(func=value))
    assert manager.reset() == {}
    assert manager.log_counts == {}


def test_without_terms_there_is_nothing_to_do(env):
    manager = make(env)
    manager.compute()
    assert manager.reset() == {}
    assert manager.masks(0.1, torch.ones(4, dtype=torch.bool)) == {}
    assert "0 active terms" in str(manager)


def test_viewers_and_tables_show_every_term(env):
    manager = make(env, term=MetricsTermCfg(func=value, log_as="goal/height", reduce="max"))
    measure(manager, [1.0, 2.0, 3.0, 4.0])
    assert manager.get_active_iterable_terms(2) == [("goal/height", [3.0])]
    assert "Metrics/goal/height" in str(manager)
