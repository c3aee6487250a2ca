"""Metrics and shared values within the steps of an environment."""

import pytest
import torch
from env_parts import group_of, zero_action

import lift_lab.envs.mdp as mdp
from lift_lab.managers import (
    CommandTerm,
    CommandTermCfg,
    CurriculumTermCfg,
    EventTermCfg,
    MetricsTermCfg,
    ObservationTermCfg,
    RewardTermCfg,
    TerminationTermCfg,
)
from lift_lab.utils.step_cache import once_a_step

ENGINES = ["native", pytest.param("warp", marks=pytest.mark.slow)]


def _elbow_x(env):
    return env.scene["robot"].data.body_pos_w[:, 2, 0] - env.scene.env_origins[:, 0]


def _end_at_the_third(env):
    return env.episode_length_buf >= torch.tensor([3, 100, 100])


@pytest.mark.parametrize("physics", ENGINES)
def test_metrics_are_of_every_step_of_an_episode_also_of_its_last(make_env, physics):
    env = make_env(
        physics=physics,
        terminations={"end": TerminationTermCfg(func=_end_at_the_third)},
        rewards={"x": RewardTermCfg(func=_elbow_x, weight=1.0)},  # reads what the metrics read
        metrics={
            "x": MetricsTermCfg(func=_elbow_x),
            "last_x": MetricsTermCfg(func=_elbow_x, reduce="last", log_as="elbow/last"),
        },
    )
    env.reset()
    rewards = []
    for _ in range(3):
        *_, extras = env.step(torch.ones(3, 2))
        rewards.append(float(env.reward_buf[0]) / env.step_dt)
    assert float(extras["log"]["Metrics/x"]) == pytest.approx(sum(rewards) / 3)
    assert float(extras["log"]["Metrics/elbow/last"]) == pytest.approx(rewards[-1])
    assert extras["log_counts"] == {"Metrics/x": 1, "Metrics/elbow/last": 1}
    assert len(set(rewards)) == 3


class _InIsaacLabsWay(CommandTerm):
    """Counts its updates in an episode, as Isaac Lab's classes measure."""

    def __init__(self, cfg, env):
        super().__init__(cfg, env)
        self.metrics["updates"] = torch.zeros(self.num_envs, device=self.device)

    @property
    def command(self):
        return self.time_left.unsqueeze(1)

    def _update_metrics(self):
        self.metrics["updates"] += 1.0

    def _resample_command(self, env_ids):
        pass

    def _update_command(self):
        pass


@pytest.mark.parametrize("physics", ENGINES)
def test_metrics_of_a_command_of_ones_own_are_logged_beside_metrics_terms(make_env, physics):
    env = make_env(
        physics=physics,
        terminations={"end": TerminationTermCfg(func=_end_at_the_third)},
        commands={"mine": CommandTermCfg(class_type=_InIsaacLabsWay, resampling_time_range=(9.0, 9.0))},
        metrics={"one": MetricsTermCfg(func=mdp.is_alive)},
    )
    env.reset()
    for _ in range(3):
        *_, extras = env.step(zero_action(env))
    log = {name: float(value) for name, value in extras["log"].items() if name.startswith("Metrics/mine")}
    assert log == {"Metrics/mine/updates": 2.0}  # the third update is of the next episode
    assert env.command_manager.get_term("mine").metrics["updates"].tolist() == [1.0, 3.0, 3.0]
    assert "Metrics/one" in extras["log"]


# -- shared values

calls: list[torch.Tensor] = []


@once_a_step
def shared_x(env, shift: float = 0.0) -> torch.Tensor:
    calls.append(env.scene["robot"].data.joint_pos.clone())
    return env.scene["robot"].data.joint_pos[:, 0] + shift


def _never(env):
    return shared_x(env) > 1e3


@pytest.fixture
def sharing(make_env):
    """An environment whose terms share a value: three before resets, two observations, an event and a curriculum."""

    def push(env, env_ids):
        """Read the value, move the joint, read it again."""
        data, before = env.scene["robot"].data, shared_x(env).clone()
        env.scene["robot"].write_joint_state_to_sim(data.joint_pos + 0.5, data.joint_vel)
        torch.testing.assert_close(shared_x(env), before + 0.5)

    env = make_env(
        observations=group_of(a=ObservationTermCfg(func=_column), b=ObservationTermCfg(func=_column)),
        terminations={"never": TerminationTermCfg(func=_never)},
        rewards={"x": RewardTermCfg(func=shared_x, weight=1.0)},
        metrics={"x": MetricsTermCfg(func=shared_x, reduce="last")},
        events={
            "default": EventTermCfg(func=mdp.reset_scene_to_default, mode="reset"),
            "push": EventTermCfg(func=push, mode="interval", interval_range_s=(0.0, 0.0), is_global_time=True),
        },
        curriculum={"x": CurriculumTermCfg(func=lambda env, env_ids: shared_x(env).mean())},
    )
    env.reset()
    calls.clear()
    return env


def _column(env):
    return shared_x(env).unsqueeze(1)


def test_terms_that_only_read_share_a_value_and_those_that_write_see_what_they_wrote(sharing):
    obs, reward, *_ = sharing.step(zero_action(sharing))
    assert len(calls) == 4  # terminations, rewards and metrics; the event twice; observations
    reached, _, _, pushed = (joint_pos[:, 0] for joint_pos in calls)
    torch.testing.assert_close(reward, reached * sharing.step_dt)
    torch.testing.assert_close(sharing.metrics_manager.episode_value("x"), reached)
    torch.testing.assert_close(pushed, reached + 0.5)
    torch.testing.assert_close(obs["policy"], pushed.unsqueeze(1).expand(3, 2))


def test_a_script_between_two_steps_sees_what_it_wrote_and_so_does_a_reset(sharing):
    robot = sharing.scene["robot"]
    sharing.step(zero_action(sharing))
    for written in (0.1, 0.2):
        robot.write_joint_state_to_sim(torch.full_like(robot.data.joint_pos, written), robot.data.joint_vel * 0.0)
        torch.testing.assert_close(shared_x(sharing), torch.full((3,), written))
    assert shared_x(sharing) is not shared_x(sharing)
    obs, _ = sharing.reset(env_ids=[1])
    torch.testing.assert_close(obs["policy"][:, 0], robot.data.joint_pos[:, 0])
    assert robot.data.joint_pos[:, 0].tolist() == pytest.approx([0.2, 0.3, 0.2])  # 0.3 is the default


def test_other_arguments_are_another_value(sharing):
    sharing.step_cache = {}
    assert shared_x(sharing) is shared_x(sharing)
    assert shared_x(sharing, 1.0) is shared_x(sharing, 1.0)
    torch.testing.assert_close(shared_x(sharing, shift=1.0), shared_x(sharing) + 1.0)
    with pytest.raises(TypeError, match="unhashable"):
        shared_x(sharing, [1.0])


def test_a_term_that_raises_leaves_no_value_behind(sharing):
    def fail(env):
        shared_x(env)
        raise RuntimeError("of the term")

    sharing.reward_manager.get_term_cfg("x").func = fail
    with pytest.raises(RuntimeError, match="of the term"):
        sharing.step(zero_action(sharing))
    assert sharing.step_cache is None
    assert shared_x(sharing) is not shared_x(sharing)
