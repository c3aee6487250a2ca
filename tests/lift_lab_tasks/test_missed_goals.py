"""Practice of missed goals: which episodes take one up, when it begins, and that it is for training alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import gymnasium as gym
import pytest
import torch

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import LiftLabError
from lift_lab_tasks.settings import Settings
from lift_lab_tasks.utils.hydra import compose

TASK = "Lift-Cube-Franka-CL"
ENVS = 300
TERM = "env.curriculum.missed_goals"
HARD_M = torch.tensor([0.599, 0.249, 0.26])


@pytest.fixture(scope="module")
def make() -> Iterator[Callable]:
    made = {}

    def build(share: float, start_step: int = 0, level: str = "null"):
        if (share, start_step, level) in made:
            return made[share, start_step, level]
        overrides = [f"{TERM}.params.share={share}", f"{TERM}.params.start_step={start_step}"]
        overrides.append(f"+{TERM}.params.level={level}")
        cfg, _ = compose(TASK, "rsl_rl_cfg_entry_point", overrides)
        cfg.scene.num_envs, cfg.seed = ENVS, 3
        env = gym.make(TASK, cfg=cfg).unwrapped
        env.reset()
        env.common_step_counter = 100  # so that an episode may have ended
        made[share, start_step, level] = env
        return env

    yield build
    for env in made.values():
        env.close()


def _end_episodes(env, missed: torch.Tensor) -> torch.Tensor:
    """End all episodes, those in `missed` having missed a goal in a corner; returns the new goals in m."""
    command = env.command_manager.get_term("object_pose")
    command.pose_command_b[missed, :3] = HARD_M
    env.metrics_manager.episode_value("success")[:] = (~missed).float()
    env.reset()
    return command.pose_command_b[:, :3].clone()


def _some() -> torch.Tensor:
    return torch.arange(ENVS) < 5


def test_a_share_of_the_episodes_has_a_goal_near_one_that_was_missed(make):
    goals_m = _end_episodes(make(share=0.4), _some())
    near = ((goals_m - HARD_M).abs() <= 0.0201).all(dim=1)
    # binomial: 0.4 of 300, and a hundredth of the uniform goals are as near by chance
    assert 88 <= int(near.sum()) <= 156
    low, high = torch.tensor([0.4, -0.25, 0.25]), torch.tensor([0.6, 0.25, 0.5])
    assert (goals_m >= low - 1e-6).all()
    assert (goals_m <= high + 1e-6).all()
    practised = goals_m[near]
    assert (practised == high).any(dim=1).any()  # drawn beyond the range and brought back to its edge
    assert practised.unique(dim=0).shape[0] > 80


def test_without_a_miss_every_goal_is_uniform(make):
    goals_m = _end_episodes(make(share=1.0), torch.zeros(ENVS, dtype=torch.bool))
    torch.testing.assert_close(goals_m.mean(dim=0), torch.tensor([0.5, 0.0, 0.375]), atol=0.035, rtol=0.0)
    torch.testing.assert_close(goals_m.std(dim=0), torch.tensor([0.2, 0.5, 0.25]) / 12**0.5, atol=0.016, rtol=0.0)


def test_a_goal_that_was_reached_at_last_is_practised_no_longer(make):
    env = make(share=1.0)
    assert ((_end_episodes(env, _some()) - HARD_M).abs() <= 0.0201).all()
    assert env.extras["log"]["Curriculum/missed_goals"].item() == pytest.approx(5 / ENVS)
    goals_m = _end_episodes(env, torch.zeros(ENVS, dtype=torch.bool))
    assert env.extras["log"]["Curriculum/missed_goals"].item() == 0.0
    assert ((goals_m - HARD_M).abs() > 0.0201).any(dim=1).float().mean() > 0.9


def test_a_goal_that_is_reached_on_the_last_step_is_not_missed(make):
    env = make(share=1.0)
    _end_episodes(env, torch.zeros(ENVS, dtype=torch.bool))
    env.episode_length_buf[:2] = env.max_episode_length - 1
    command = env.command_manager.get_term("object_pose")
    data = env.scene["object"].data
    command.pose_command_b[1, :3] = data.root_pos_w[1] - env.scene["robot"].data.root_pos_w[1]
    env.step(torch.zeros(ENVS, 8))
    assert float(env.extras["log"]["Curriculum/missed_goals"]) == pytest.approx(1 / ENVS)


def test_episodes_that_practise_are_left_out_of_the_means(make):
    env = make(share=0.4)
    near = ((_end_episodes(env, _some()) - HARD_M).abs() <= 0.0201).all(dim=1)
    env.metrics_manager.compute()
    env.metrics_manager.episode_value("success")[:] = (~near).float()
    env.reset()
    # a hundredth of the uniform goals are as near by chance
    assert env.extras["log"]["Metrics/success_rate"].item() > 0.95
    _end_episodes(make(share=1.0), _some())
    make(share=1.0).reset()
    assert "Metrics/success_rate" not in make(share=1.0).extras["log"]


def test_before_it_begins_nothing_is_drawn_that_would_not_be_without_it(make):
    torch.manual_seed(5)
    early = _end_episodes(make(share=1.0, start_step=1000), _some())
    torch.manual_seed(5)
    never = _end_episodes(make(share=0.0), _some())
    assert torch.equal(early, never)


def test_it_begins_when_the_success_rate_reaches_its_level(make):
    env = make(share=1.0, level="0.95")
    near = (_end_episodes(env, torch.arange(ENVS) < 16) - HARD_M).abs() <= 0.0201  # 94.7 %
    assert near.all(dim=1).float().mean() < 0.1
    near = (_end_episodes(env, _some()) - HARD_M).abs() <= 0.0201  # 98.3 %
    assert near.all()


def test_a_policy_is_shown_and_judged_with_uniform_goals():
    settings = Settings(TASK, None, [])
    settings.resolve()
    cfg = settings.env
    assert cfg.curriculum.missed_goals is None


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (f"{TERM}.params.share=1.5", "share is 1.5"),
        (f"+{TERM}.params.command_name=other", "object_pose"),
        (f"+{TERM}.params.metric=sucess", "practise_missed_goals: its metric 'sucess' .* did you mean 'success'"),
        ("env.metrics=null", "practise_missed_goals: its metric 'success' is no term of env.metrics"),
    ],
)
def test_a_wrong_parameter_is_named(override, message):
    cfg, _ = compose(TASK, "rsl_rl_cfg_entry_point", [override])
    cfg.scene.num_envs = 1
    with pytest.raises(LiftLabError, match=message):
        gym.make(TASK, cfg=cfg)
