"""Curriculum terms as functions of the step counter."""

from types import SimpleNamespace

import pytest
import torch

import lift_lab.envs.mdp as mdp
from lift_lab.managers import CurriculumTermCfg, RewardTermCfg
from lift_lab.utils.errors import ConfigError

IDS = [0]


class _Rewards:
    def __init__(self):
        self.cfg = SimpleNamespace(penalty=RewardTermCfg(func=mdp.action_l2, weight=-1e-4))
        self.replaced = 0

    def get_term_cfg(self, name):
        return getattr(self.cfg, name)

    def set_term_cfg(self, name, cfg):
        assert cfg is self.get_term_cfg(name)
        self.replaced += 1


@pytest.fixture
def env():
    command = SimpleNamespace(goal=SimpleNamespace(ranges=SimpleNamespace(pos_x=(0.4, 0.6), names=["a", "b"])))
    return SimpleNamespace(
        num_envs=1,
        named_objects=dict,
        device="cpu",
        common_step_counter=0,
        reward_manager=_Rewards(),
        command_manager=SimpleNamespace(cfg=command),
        metrics_manager=SimpleNamespace(
            active_terms=["success"],
            counted_ids=lambda env_ids: slice(None),
            cfg=SimpleNamespace(success=SimpleNamespace(params={"threshold": 0.02})),
        ),
    )


def _term(func, env, **params):
    return func(CurriculumTermCfg(func=func, params=params), env), params


def test_a_modified_weight_changes_after_more_than_num_steps(env):
    term, params = _term(mdp.modify_reward_weight, env, term_name="penalty", weight=-0.1, num_steps=100)
    weights = {}
    for step in (0, 99, 100, 101, 5000):
        env.common_step_counter = step
        weights[step] = term(env, IDS, **params)
    assert weights == {0: -1e-4, 99: -1e-4, 100: -1e-4, 101: -0.1, 5000: -0.1}
    assert env.reward_manager.cfg.penalty.weight == -0.1


def test_a_weight_changes_num_steps_after_a_metric_reaches_its_level(env):
    env.num_envs, ended = 4, torch.zeros(4)
    env.metrics_manager.episode_value = lambda name: {"success": ended}[name]
    env.metrics_manager.counted_ids = lambda env_ids: torch.as_tensor(env_ids)
    term, params = _term(mdp.modify_reward_weight, env, term_name="penalty", weight=-0.1, num_steps=10, level=0.7)

    def weight(step, ids, *success):
        env.common_step_counter = step
        ended[ids] = torch.tensor(success)
        return term(env, ids, **params)

    assert weight(0, [0, 1, 2, 3], 1.0, 1.0, 1.0, 1.0) == -1e-4  # no episode has ended
    assert weight(30, [0, 1], 1.0, 1.0) == -1e-4  # mean 0.5
    assert weight(50, [2], float("nan")) == -1e-4
    assert weight(60, [0, 3], 1.0, 1.0) == -1e-4  # mean 0.75, reached
    saved = term.state_dict()
    assert weight(70, [0], 0.0) == -1e-4
    assert weight(71, [0], 0.0) == -0.1
    other, _ = _term(mdp.modify_reward_weight, env, term_name="penalty", weight=-0.2, num_steps=10, level=0.7)
    other.load_state_dict(saved)
    env.common_step_counter = 71
    assert other(env, [0], **params | {"weight": -0.2}) == -0.2


@pytest.mark.parametrize(
    ("settings", "message"),
    [({"metric": "success"}, "no effect without level"), ({"metric": "sucess", "level": 0.5}, "mean 'success'")],
)
def test_a_level_needs_a_metric_and_a_metric_a_level(env, settings, message):
    with pytest.raises(ConfigError, match=message):
        _term(mdp.modify_reward_weight, env, term_name="penalty", weight=-0.1, num_steps=0, **settings)


@pytest.mark.parametrize(
    ("settings", "expected"),
    [
        # Equation (1): w0 + (w1 - w0) min(t, t_max) / t_max
        ({}, {0: -0.1, 1: -0.10009, 5_000: -0.55, 9_999: -0.99991, 10_000: -1.0, 30_000: -1.0}),
        # one jump
        ({"update_interval": 10_000}, {0: -0.1, 9_999: -0.1, 10_000: -1.0, 30_000: -1.0}),
        # stairs
        ({"update_interval": 2_500}, {2_499: -0.1, 2_500: -0.325, 4_999: -0.325, 7_500: -0.775, 10_000: -1.0}),
        # an interval that does not divide the ramp
        ({"update_interval": 7_000}, {6_999: -0.1, 7_000: -0.73, 10_000: -0.73, 14_000: -1.0}),
        ({"start_step": 4_000}, {3_999: -0.1, 4_000: -0.1, 9_000: -0.55, 14_000: -1.0}),
    ],
)
def test_an_annealed_weight_follows_the_equation(env, settings, expected):
    term, params = _term(
        mdp.anneal_reward_weight,
        env,
        term_name="penalty",
        initial_weight=-0.1,
        final_weight=-1.0,
        num_steps=10_000,
        **settings,
    )
    for step, weight in expected.items():
        env.common_step_counter = step
        assert term(env, IDS, **params) == pytest.approx(weight, abs=1e-12)
        assert env.reward_manager.cfg.penalty.weight == pytest.approx(weight, abs=1e-12)


def test_an_annealed_weight_needs_no_memory_of_earlier_steps(env):
    params = {"term_name": "penalty", "initial_weight": 0.0, "final_weight": 2.0, "num_steps": 8, "update_interval": 2}
    env.common_step_counter = 5
    fresh, _ = _term(mdp.anneal_reward_weight, env, **params)
    assert fresh(env, IDS, **params) == pytest.approx(1.0)


@pytest.mark.parametrize("setting", [{"num_steps": 0}, {"update_interval": 0}, {"start_step": -1}])
def test_an_impossible_ramp_is_an_error(env, setting):
    params = {"term_name": "penalty", "initial_weight": 0.0, "final_weight": 1.0, "num_steps": 10, **setting}
    with pytest.raises(ConfigError, match=next(iter(setting))):
        _term(mdp.anneal_reward_weight, env, **params)


def _later(env, env_ids, old, value, num_steps):
    return value if env.common_step_counter > num_steps else mdp.modify_env_param.NO_CHANGE


@pytest.mark.parametrize(
    ("func", "address"),
    [
        (mdp.modify_env_param, "command_manager.cfg.goal.ranges.pos_x"),
        (mdp.modify_term_cfg, "commands.goal.ranges.pos_x"),
    ],
)
def test_a_parameter_changes_when_its_function_says_so(env, func, address):
    term, params = _term(
        func, env, address=address, modify_fn=_later, modify_params={"value": (0.0, 1.0), "num_steps": 3}
    )
    ranges = env.command_manager.cfg.goal.ranges
    env.common_step_counter = 3
    term(env, IDS, **params)
    assert ranges.pos_x == (0.4, 0.6)
    env.common_step_counter = 4
    term(env, IDS, **params)
    assert ranges.pos_x == (0.0, 1.0)


@pytest.mark.parametrize(
    ("address", "read"),
    [
        ("commands.goal.ranges.pos_x[1]", lambda r: r.pos_x[1]),  # a tuple is replaced
        ("commands.goal.ranges.names[0]", lambda r: r.names[0]),
    ],
)
def test_a_parameter_inside_a_sequence_can_be_changed(env, address, read):
    term, params = _term(mdp.modify_term_cfg, env, address=address, modify_fn=lambda env, ids, old: 9.0)
    term(env, IDS, **params)
    assert read(env.command_manager.cfg.goal.ranges) == 9.0


def test_a_parameter_inside_a_dictionary_can_be_changed(env):
    env.reward_manager.cfg.penalty.params = {"range": {"x": 1.0}}
    for address in ("rewards.penalty.params.range.x", "rewards.penalty.params['range']['x']"):
        term, params = _term(mdp.modify_term_cfg, env, address=address, modify_fn=lambda env, ids, old: old + 1.0)
        term(env, IDS, **params)
    assert env.reward_manager.cfg.penalty.params["range"]["x"] == 3.0
    address = "metrics.success.params.threshold"
    term, params = _term(mdp.modify_term_cfg, env, address=address, modify_fn=lambda env, ids, old: 2.0 * old)
    term(env, IDS, **params)
    assert env.metrics_manager.cfg.success.params["threshold"] == 0.04


@pytest.mark.parametrize(
    ("func", "address", "message"),
    [
        (mdp.modify_term_cfg, "commands.gaol.ranges.pos_x", "'goal'"),
        (mdp.modify_term_cfg, "command.goal.ranges.pox_x", "'pos_x'"),
        (mdp.modify_term_cfg, "comands.goal", "'commands'"),
        (mdp.modify_env_param, "command_manager.cfg.goal.ranges.pos_x[2]", "has no '2'"),
        (mdp.modify_env_param, "command_manager..cfg", "is not a path"),
    ],
)
def test_an_address_that_leads_nowhere_is_an_error_at_once(env, func, address, message):
    with pytest.raises(ConfigError, match=message):
        _term(func, env, address=address, modify_fn=_later)


def _succeeding(env, outcomes):
    """Let the metric tell these outcomes of the episodes that end."""
    env.metrics_manager.episode_value = lambda name: torch.tensor(outcomes)


def test_a_weight_that_follows_success_moves_only_while_the_rate_allows(env):
    settings = {"initial_weight": -1e-4, "final_weight": -1e-1, "num_steps": 300, "window": 4}
    term, params = _term(mdp.anneal_reward_weight_on_success, env, term_name="penalty", **settings)
    ids = slice(None)
    log = []
    # (step, outcomes): rates 1/2 of 2 episodes, then 3/4 of 4, then 3/4 + (1 - 3/4) 2/4 = 7/8, then 15/16, ...
    for step, outcomes in (
        (0, [0.0, 0.0]),  # the first reset ends no episode
        (50, [1.0, 0.0]),  # fewer than 4 episodes: wait
        (80, [1.0, 1.0]),  # 0.75 rests
        (180, [1.0, 1.0]),  # 0.875 raises by 100/300 of three decades
        (280, [1.0, 1.0]),  # 0.9375, again
        (290, [0.0, 0.0, 0.0, 0.0]),  # 0: 10/300 back
        (990, [1.0, 1.0, 1.0, 1.0]),  # 1: to the end and no further
    ):
        env.common_step_counter = step
        _succeeding(env, outcomes)
        log.append(term(env, ids, **params))
    assert [entry["success_rate"] for entry in log] == pytest.approx([0, 0.5, 0.75, 0.875, 0.9375, 0, 1])
    decades = [0, 0, 0, 1, 2, 1.9, 3]
    assert [entry["weight"] for entry in log] == pytest.approx([-(10.0 ** (d - 4)) for d in decades], rel=1e-9)
    assert env.reward_manager.cfg.penalty.weight == pytest.approx(-0.1)


def test_a_weight_that_follows_success_can_move_evenly_and_continues_from_where_it_is(env):
    settings = {"initial_weight": 0.0, "final_weight": -1.0, "num_steps": 100, "window": 1, "geometric": False}
    env.reward_manager.cfg.penalty.weight = -0.4  # as a checkpoint left it
    term, params = _term(mdp.anneal_reward_weight_on_success, env, term_name="penalty", **settings)
    env.common_step_counter = 10
    _succeeding(env, [1.0])
    assert term(env, slice(None), **params)["weight"] == pytest.approx(-0.5)


@pytest.mark.parametrize(
    "settings",
    [
        {"num_steps": 0},
        {"window": 0},
        {"raise_at": 0.3},
        {"initial_weight": 0.0},
        {"initial_weight": -1.0},
        {"metric": "sucess"},
    ],
)
def test_a_weight_that_follows_success_checks_its_settings(env, settings):
    params = {"initial_weight": -1e-4, "final_weight": -1.0, "num_steps": 100} | settings
    with pytest.raises(ConfigError, match="anneal_reward_weight_on_success"):
        _term(mdp.anneal_reward_weight_on_success, env, term_name="penalty", **params)
