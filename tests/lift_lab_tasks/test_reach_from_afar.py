"""The wider scale of the reaching reward: until when it holds, what it pays, and that it is for training alone."""

from __future__ import annotations

import gymnasium as gym
import pytest
import torch

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError
from lift_lab_tasks.settings import Settings
from lift_lab_tasks.utils.hydra import compose

TASKS = ["Lift-Cube-Franka-IK-Rel", "Lift-Cube-Franka-IK-Abs"]
TERM = "env.curriculum.reach_from_afar"


@pytest.fixture
def env():
    cfg, _ = compose(TASKS[0], "rsl_rl_cfg_entry_point", [f"{TERM}.params.num_steps=100"])
    cfg.scene.num_envs, cfg.seed = 2, 3
    env = gym.make(TASKS[0], cfg=cfg).unwrapped
    env.reset()
    yield env
    env.close()


def _pays(env) -> torch.Tensor:
    """What the reaching term pays a second in the present state."""
    cfg = env.reward_manager.get_term_cfg("reaching_object")
    return cfg.func(env, **cfg.params)


def test_the_wider_scale_holds_until_its_step_and_then_the_terms_own(env):
    distance_m = (env.scene["object"].data.root_pos_w - env.scene["ee_frame"].data.target_pos_w[:, 0]).norm(dim=1)
    torch.testing.assert_close(_pays(env), 1 - torch.tanh(distance_m / 0.3))
    for step, std_m in ((99, 0.3), (100, 0.1), (50, 0.3)):  # it follows from the step alone, as after a resume
        env.common_step_counter = step
        assert env.curriculum_manager.get_term_cfg("reach_from_afar").func(env, None, std=0.3, num_steps=100) == std_m
        torch.testing.assert_close(_pays(env), 1 - torch.tanh(distance_m / std_m))


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("preset", ["explore", "step", "linear", "success"])
def test_every_curriculum_of_a_task_in_task_space_has_it_and_a_judged_policy_does_not(task, preset):
    settings = Settings(task, None, [f"env/curriculum={preset}"])
    cfg = settings.env
    assert cfg.curriculum.reach_from_afar is not None
    assert cfg.rewards.reaching_object.params["std"] == 0.1
    settings.resolve()
    assert cfg.curriculum.reach_from_afar is None


@pytest.mark.parametrize(
    ("override", "message"),
    [
        (f"{TERM}.params.std=0.05", "std is 0.05"),
        (f"+{TERM}.params.term_name=lifting_object", "no parameter 'std'"),
    ],
)
def test_a_wrong_parameter_is_named(override, message):
    cfg, _ = compose(TASKS[0], "rsl_rl_cfg_entry_point", [override])
    cfg.scene.num_envs = 1
    with pytest.raises(ConfigError, match=message):
        gym.make(TASKS[0], cfg=cfg)
