"""Evaluation counts whole episodes of every environment alike, and sees success at any step of an episode."""

import math
from types import SimpleNamespace

import gymnasium as gym
import pytest
import torch

from lift_lab.envs import mdp
from lift_lab.managers import CurriculumTermCfg, MetricsTermCfg, SceneEntityCfg, TerminationTermCfg
from lift_lab.utils.errors import ConfigError
from lift_lab_rl.counters import counters, load_counters
from lift_lab_rl.evaluation import PROBE, SuccessProbe, add_success_probe, evaluate, milestones
from lift_lab_rl.rsl_rl import RslRlVecEnvWrapper
from lift_lab_tasks.utils import parse_env_cfg


class CountingEnv:
    """Environment k has episodes of ``lengths[k]`` steps, 1 of reward a step, and success at step ``wins[k]``."""

    device, step_dt = "cpu", 0.02

    def __init__(self, lengths, wins):
        self.num_envs = len(lengths)
        self.lengths, self.wins = torch.tensor(lengths), torch.tensor(wins)
        self.episode_length_buf = torch.zeros(self.num_envs, dtype=torch.long)
        self.fired = {"drop": None, "time_out": None}
        cfg = SimpleNamespace(params={"success": lambda env: env.episode_length_buf == env.wins, "success_params": {}})
        self.probe = SuccessProbe(cfg, self)
        self.termination_manager = SimpleNamespace(
            active_terms=["drop", "time_out", PROBE],
            get_term=lambda name: self.fired[name],
            get_term_cfg=lambda name: SimpleNamespace(func=self.probe),
        )

    unwrapped = property(lambda self: self)

    def get_observations(self):
        return None

    def step(self, actions):
        self.episode_length_buf = self.episode_length_buf + 1
        assert not self.probe(
            self, **{"success": lambda env: env.episode_length_buf == env.wins, "success_params": {}}
        ).any()
        done = self.episode_length_buf >= self.lengths
        self.fired = {"drop": done & (self.lengths < 5), "time_out": done & (self.lengths >= 5)}
        self.episode_length_buf = torch.where(done, 0, self.episode_length_buf)
        return None, torch.ones(self.num_envs), done.long(), {}


def test_short_episodes_count_no_more_than_long_ones():
    # Environment 0 ends ten times while environment 1 ends once; each counts twice.
    env = CountingEnv(lengths=[1, 10], wins=[0, 10])
    result = evaluate(env, lambda obs: None, 4)
    assert [episode.length for episode in result.episodes] == [1, 10, 1, 10]
    assert [episode.reward for episode in result.episodes] == [1.0, 10.0, 1.0, 10.0]
    assert result.success_rate() == 0.5
    assert result.success_rate(1) == 0.0
    assert result.summary()["terminations"] == {"drop": 2, "time_out": 2}


def test_means_over_some_of_the_episodes_weigh_as_many():
    class Logs(CountingEnv):
        """Of the two episodes that end in step 2 one is behind the mean, of the one in step 5 that one."""

        def step(self, actions):
            obs, rewards, dones, _ = super().step(actions)
            log = {"Metrics/some": 2.0 if dones.sum() == 2 else 6.0}
            return obs, rewards, dones, {"log": log, "log_counts": {"Metrics/some": 1}}

    assert evaluate(Logs(lengths=[2, 2, 5], wins=[0, 0, 0]), lambda obs: None, 3).logs == {"Metrics/some": 4.0}


def test_an_evaluation_can_end_after_a_round():
    seen = []

    def go_on(found):
        seen.append([episode.length for episode in found.episodes])
        return len(seen) < 2

    result = evaluate(CountingEnv(lengths=[1, 10], wins=[0, 10]), lambda obs: None, 8, go_on)
    assert seen == [[1, 10], [1, 10, 1, 10]]
    assert [episode.length for episode in result.episodes] == seen[-1]
    always = evaluate(CountingEnv(lengths=[1, 10], wins=[0, 10]), lambda obs: None, 3, lambda found: True)
    assert [episode.length for episode in always.episodes] == [1, 10, 1]


def test_a_policy_with_a_memory_forgets_at_the_end_of_an_episode():
    env, forgotten = CountingEnv(lengths=[2, 4], wins=[0, 0]), []

    class Policy:
        def __call__(self, obs):
            return None

        def reset(self, dones):
            forgotten.append(dones.tolist())

    evaluate(env, Policy(), 2)
    assert forgotten == [[0, 0], [1, 0], [0, 0], [1, 1]]


def test_success_at_the_last_step_and_in_the_middle_both_count():
    env = CountingEnv(lengths=[6, 6, 6], wins=[6, 2, 0])
    result = evaluate(env, lambda obs: None, 3)
    assert [episode.success_step for episode in result.episodes] == [6, 2, 0]
    assert result.summary()["time_to_success_s"] == pytest.approx((6 + 2) / 2 * 0.02)


def test_rates_are_given_over_the_first_10_50_100_and_all():
    assert milestones(7) == [7]
    assert milestones(10) == [10]
    assert milestones(120) == [10, 50, 100, 120]
    assert milestones(5000) == [10, 50, 100, 500, 1000, 5000]
    env = CountingEnv(lengths=[3] * 20, wins=[1] * 10 + [0] * 10)
    assert evaluate(env, lambda obs: None, 20).rates() == {10: 1.0, 20: 0.5}


def reached(env, threshold=0.02, robot_cfg=SceneEntityCfg("robot")):
    return env


def test_the_probe_takes_success_from_the_registration_or_the_term_of_that_name():
    cfg = SimpleNamespace(terminations={})
    add_success_probe(cfg, reached)
    params = cfg.terminations[PROBE].params
    assert params["success"] is reached
    assert params["success_params"]["robot_cfg"].name == "robot"

    cfg = SimpleNamespace(terminations={"success": TerminationTermCfg(func=reached, params={"threshold": 0.1})})
    add_success_probe(cfg, None)
    assert cfg.terminations[PROBE].params["success_params"]["threshold"] == 0.1

    metrics = SimpleNamespace(success=MetricsTermCfg(func=reached, params={"threshold": 0.3}, reduce="max"))
    cfg = SimpleNamespace(terminations={}, metrics=metrics)
    add_success_probe(cfg, None)
    assert cfg.terminations[PROBE].params["success_params"]["threshold"] == 0.3

    for cfg in (SimpleNamespace(terminations={}), SimpleNamespace(terminations={}, metrics=None)):
        with pytest.raises(ConfigError, match="does not say what success is"):
            add_success_probe(cfg, None)


def integers(env):
    return env.episode_length_buf


@pytest.mark.parametrize(
    ("success", "message"),
    [
        (math.sqrt, r"success: sqrt\(env, ...\) cannot be called: must be real number"),
        (integers, r"success: integers has to return a bool tensor of shape \(2,\), not torch.int64 of shape \(2,\)"),
        (lambda env: torch.ones(3, dtype=torch.bool), r"bool tensor of shape \(2,\), not torch.bool of shape \(3,\)"),
        (lambda env: True, "not bool"),
    ],
)
def test_a_function_that_tells_no_success_is_named(success, message):
    cfg = SimpleNamespace(terminations={})
    add_success_probe(cfg, success)
    env = CountingEnv(lengths=[3, 3], wins=[0, 0])
    with pytest.raises(ConfigError, match=message):
        SuccessProbe(cfg.terminations[PROBE], env)(env, **cfg.terminations[PROBE].params)


# -- the curriculum of a checkpoint


@pytest.fixture
def cartpole():
    """Makes wrapped cartpoles with a curriculum, whose episodes have 30 steps."""
    made = []

    def make(**curriculum):
        cfg = parse_env_cfg("Cartpole", "cpu", 4)
        cfg.seed, cfg.sim.num_threads, cfg.episode_length_s = 3, 1, 0.5
        cfg.curriculum = {
            name: CurriculumTermCfg(func=func, params=params) for name, (func, params) in curriculum.items()
        }
        add_success_probe(cfg, lambda env: env.episode_length_buf > 1000)
        made.append(RslRlVecEnvWrapper(gym.make("Cartpole", cfg=cfg)))
        return made[-1]

    yield make
    for env in made:
        env.close()


def test_the_curriculum_holds_still_in_an_evaluation(cartpole):
    term = (mdp.modify_reward_weight, {"term_name": "alive", "weight": 100.0, "num_steps": 17_999})
    env = cartpole(alive=term)
    inner = env.unwrapped
    inner.common_step_counter = 17_990
    env.reset()
    result = evaluate(env, lambda obs: torch.zeros(4, 1), 12)
    assert inner.common_step_counter > 18_050
    assert len(result.episodes) == 12
    assert inner.reward_manager.get_term_cfg("alive").weight == 1.0
    assert max(episode.reward for episode in result.episodes) < 1.0  # 0.5 s at a weight of 1
    env.reset()  # and goes on afterwards
    assert inner.reward_manager.get_term_cfg("alive").weight == 100.0


def test_weights_of_a_checkpoint_are_for_the_terms_that_a_curriculum_names(cartpole):
    by_name = (mdp.modify_reward_weight, {"term_name": "alive", "weight": 100.0, "num_steps": 10**9})
    by_path = (mdp.modify_term_cfg, {"address": "rewards.pole_pos.weight", "modify_fn": lambda env, ids, old: old})
    trained, plain = cartpole(alive=by_name, pole=by_path).unwrapped, cartpole().unwrapped
    before = {name: plain.reward_manager.get_term_cfg(name).weight for name in plain.reward_manager.active_terms}
    for number, name in enumerate(before):
        trained.reward_manager.get_term_cfg(name).weight = 50.0 + number
    trained.common_step_counter = 99
    saved = counters(trained)
    for env, expected in ((plain, before), (trained, before | {"alive": 50.0, "pole_pos": 52.0})):
        for name, weight in before.items():
            env.reward_manager.get_term_cfg(name).weight = weight
        load_counters(env, saved)
        assert env.common_step_counter == 99
        assert {name: env.reward_manager.get_term_cfg(name).weight for name in before} == expected
