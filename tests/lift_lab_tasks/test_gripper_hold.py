"""The hold of the gripper while a policy hovers: when it begins and ends, and that it is for training alone."""

from __future__ import annotations

import gymnasium as gym
import pytest
import torch

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError
from lift_lab_tasks.settings import Settings
from lift_lab_tasks.utils.hydra import compose

TASK = "Lift-Cube-Franka-CL"
ENVS = 4


@pytest.fixture
def env():
    cfg, _ = compose(TASK, "rsl_rl_cfg_entry_point", [])
    cfg.scene.num_envs, cfg.seed = ENVS, 3
    env = gym.make(TASK, cfg=cfg).unwrapped
    env.reset()
    env.common_step_counter = 1
    yield env
    env.close()


def _end_episodes(env, reached: float, lifted: float) -> float:
    """End all episodes with these shares of what reaching and lifting can pay; returns the time of the hold in s."""
    longest_s = env.max_episode_length_s
    env.reward_manager.episode_sum("reaching_object").fill_(reached * 1.0 * longest_s)
    env.reward_manager.episode_sum("lifting_object").fill_(lifted * 15.0 * longest_s)
    env.reset()
    return env.extras["log"]["Curriculum/gripper_hold"].item()


def _stays_closed(env) -> bool:
    """Whether an opening action is ignored right after a closing one."""
    gripper = env.action_manager.get_term("gripper_action")
    for action in (-1.0, 1.0):
        gripper.process_actions(torch.full((ENVS, 1), action))
    return bool((gripper.processed_actions < 0.02).all())


def test_the_hold_lasts_from_reaching_to_lifting_and_does_not_come_back(env):
    assert _end_episodes(env, reached=0.6, lifted=0.0) == 0.0
    assert not _stays_closed(env)
    assert _end_episodes(env, reached=0.7, lifted=0.05) == pytest.approx(0.1)
    assert _stays_closed(env)
    assert _end_episodes(env, reached=0.3, lifted=0.05) == pytest.approx(0.1)  # closing gets in the way of reaching
    assert _end_episodes(env, reached=0.7, lifted=0.15) == 0.0
    assert not _stays_closed(env)
    assert _end_episodes(env, reached=0.7, lifted=0.0) == 0.0


def test_the_episodes_that_ended_of_late_count_by_their_number(env):
    sums = env.reward_manager.episode_sum("reaching_object")
    term = env.curriculum_manager.get_term_cfg("gripper_hold").func
    sums[:] = torch.tensor([4.0, 3.0, 0.0, 0.0])  # of 5 a second for 5 s: shares 0.8 and 0.6
    env.curriculum_manager.compute(torch.tensor([0, 1]))
    # two of four: half of the way from 0 to their mean of 0.7
    assert term._reached.item() == pytest.approx(0.35)


def test_nothing_is_held_in_a_task_that_does_not_pay_for_lifting(env):
    env.reward_manager.get_term_cfg("reaching_object").weight = 0.0
    assert _end_episodes(env, reached=0.9, lifted=0.0) == 0.0


def test_a_policy_is_shown_and_judged_without_the_hold():
    settings = Settings(TASK, None, [])
    settings.resolve()
    cfg = settings.env
    assert cfg.curriculum.gripper_hold is None
    assert cfg.curriculum.joint_vel is not None


def test_any_curriculum_term_may_be_for_training_only():
    settings = Settings(TASK, None, [])
    assert not settings.env.curriculum.joint_vel.training_only
    settings.env.curriculum.joint_vel.training_only = True
    settings.resolve()
    assert settings.env.curriculum.joint_vel is None


def test_a_hold_that_is_asked_for_stays():
    override = "env.curriculum.gripper_hold.params.close_time_s=0.2"
    settings = Settings(TASK, None, [override])
    settings.resolve()
    cfg = settings.env
    assert cfg.curriculum.gripper_hold.params["close_time_s"] == 0.2


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("env.curriculum.gripper_hold.params.reached=2", "reached is 2"),
        ("+env.curriculum.gripper_hold.params.action_name=arm_action", "binary joint action"),
    ],
)
def test_a_wrong_parameter_is_named(override, message):
    cfg, _ = compose(TASK, "rsl_rl_cfg_entry_point", [override])
    cfg.scene.num_envs = 1
    with pytest.raises(ConfigError, match=message):
        gym.make(TASK, cfg=cfg)
