"""What the lift task measures of an episode for the study's report."""

from itertools import pairwise

import pytest
import torch

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab_tasks.manager_based.manipulation.lift.config.franka.joint_pos_env_cfg import FrankaCubeLiftEnvCfg
from lift_lab_tasks.manager_based.manipulation.lift.mdp import object_position_error


@pytest.fixture(scope="module")
def env():
    cfg = FrankaCubeLiftEnvCfg()
    cfg.scene.num_envs, cfg.sim.device, cfg.seed = 3, "cpu", 1
    made = ManagerBasedRLEnv(cfg)
    yield made
    made.close()


def _now(env, name):
    """A metric of the running episodes."""
    return env.metrics_manager.episode_value(name)


def _put_goal_on_object(env, index):
    goal_b = env.scene["object"].data.root_pos_w - env.scene["robot"].data.root_pos_w  # the root is not turned
    env.command_manager.get_term("object_pose").pose_command_b[index, :3] = goal_b[index]


def _put(env, height_m, index):
    """Put one environment's cube over its start, at a height."""
    pose = env.scene["object"].data.root_pose_w.clone()
    pose[index, :3] = env.scene.env_origins[index] + torch.tensor([0.5, 0.0, height_m])
    env.scene["object"].write_root_pose_to_sim(pose)
    env.scene["object"].write_root_velocity_to_sim(torch.zeros(env.num_envs, 6))
    env.sim.physics.refresh()


def test_smoothness_is_the_mean_over_the_steps_of_an_episode(env):
    env.reset()
    arm = slice(0, 7)
    actions = [0.1 * torch.randn(3, 8) for _ in range(4)]
    speeds = [env.scene["robot"].data.joint_vel[:, arm].clone()]
    for action in actions:
        env.step(action)
        speeds.append(env.scene["robot"].data.joint_vel[:, arm].clone())
    changes = [(b - a).square().sum(1) for a, b in pairwise([torch.zeros(3, 8), *actions])]
    torch.testing.assert_close(_now(env, "squared_action_change"), torch.stack(changes).mean(0))
    accelerations = [((b - a) / 0.02).square().mean(1) for a, b in pairwise(speeds)]
    torch.testing.assert_close(_now(env, "squared_joint_acceleration"), torch.stack(accelerations).mean(0))


def test_time_to_success_counts_only_episodes_that_succeeded(env):
    env.reset()
    for _ in range(3):
        env.step(torch.zeros(3, 8))
    _put_goal_on_object(env, 1)
    for _ in range(2):
        env.step(torch.zeros(3, 8))
    assert _now(env, "success").tolist() == [0.0, 1.0, 0.0]
    log, counts = env.metrics_manager.reset(torch.tensor([0, 1])), env.metrics_manager.log_counts
    assert set(counts) == set(log)
    assert float(log["Metrics/object_pose/time_to_success_s"]) == pytest.approx(4 * 0.02)
    assert counts.pop("Metrics/object_pose/time_to_success_s") == 1  # of those that end, one succeeded
    assert set(counts.values()) == {2}
    assert float(log["Metrics/success_rate"]) == 0.5
    assert "Metrics/object_pose/time_to_success_s" not in env.metrics_manager.reset(torch.tensor([1, 2]))


@pytest.fixture
def before_resets(env, monkeypatch):
    """What the object's position and the joints' velocities were when episodes ended: a pair for each such step."""
    seen, reset_idx = [], env._reset_idx

    def look(env_ids):
        data = env.scene["object"].data.root_pos_w, env.scene["robot"].data.joint_vel[:, :7]
        seen.append(tuple(value.clone() for value in data))
        reset_idx(env_ids)

    monkeypatch.setattr(env, "_reset_idx", look)
    return seen


def _end_with_the_next_step(env, index):
    env.episode_length_buf[index] = env.max_episode_length - 1


def test_what_happens_on_the_last_step_of_an_episode_counts(env, before_resets):
    env.reset()
    _put(env, 0.3, 1)  # held
    env.step(torch.zeros(3, 8))
    for index in (0, 1):
        _end_with_the_next_step(env, index)
    _put_goal_on_object(env, 0)
    _put(env, 0.02, 1)  # and down
    goals = env.command_manager.get_term("object_pose").goal_pos_w.clone()
    *_, extras = env.step(torch.zeros(3, 8))
    log = {name.rpartition("/")[2]: float(value) for name, value in extras["log"].items() if "Metrics" in name}
    positions, _ = before_resets[-1]
    assert log["success_rate"] == 0.5
    assert log["time_to_success_s"] == pytest.approx(env.max_episode_length_s)
    assert log["object_position_error"] == pytest.approx(float((positions - goals).norm(dim=1)[:2].mean()), rel=1e-5)
    assert log["first_pick_drop"] == 0.5


def test_every_step_counts_once_for_the_smoothness_of_episodes_that_end_and_of_those_that_go_on(env, before_resets):
    env.reset()
    actions = [torch.zeros(3, 8), *(0.1 * torch.randn(3, 8) for _ in range(4))]
    speeds = [env.scene["robot"].data.joint_vel[:, :7].clone()]
    for step, action in enumerate(actions[1:]):
        if step == 2:
            _end_with_the_next_step(env, 0)
        *_, extras = env.step(action)
        if step == 2:
            log = dict(extras["log"])
            speeds.append(before_resets[-1][1])
        else:
            speeds.append(env.scene["robot"].data.joint_vel[:, :7].clone())
    changes = torch.stack([(b - a).square().sum(1) for a, b in pairwise(actions)])
    accelerations = torch.stack([((b - a) / 0.02).square().mean(1) for a, b in pairwise(speeds)])
    for name, values in (("squared_action_change", changes), ("squared_joint_acceleration", accelerations)):
        torch.testing.assert_close(log[f"Metrics/object_pose/{name}"], values[:3, 0].mean())
        torch.testing.assert_close(_now(env, name)[1:], values[:, 1:].mean(0))


def test_an_action_of_nan_leaves_its_step_out_of_the_smoothness(env):
    env.reset()
    env.step(torch.full((3, 8), 0.1))  # a squared change of 8 * 0.01
    action = torch.full((3, 8), 0.1)
    action[2] = float("nan")
    *_, extras = env.step(action)
    assert float(extras["log"]["Metrics/object_pose/squared_action_change"]) == pytest.approx(0.08)


def test_a_first_pick_is_dropped_when_the_object_was_held_up_and_lies_again(env):
    env.reset()
    for height in (0.3, 0.05, 0.02):  # held, lower but not down, down
        _put(env, height, 0)
        env.step(torch.zeros(3, 8))
        if height > 0.02:
            assert _now(env, "first_pick_drop").tolist() == [0.0, 0.0, 0.0]
    assert _now(env, "first_pick_drop").tolist() == [1.0, 0.0, 0.0]
    _put(env, 0.05, 1)  # never above 0.06 m: not a pick
    env.step(torch.zeros(3, 8))
    _put(env, 0.02, 1)
    env.step(torch.zeros(3, 8))
    assert _now(env, "first_pick_drop").tolist() == [1.0, 0.0, 0.0]


def test_the_distance_to_the_goal_follows_whoever_writes_the_object_or_the_goal(env):
    env.reset()
    term, of_reward = env.command_manager.get_term("object_pose"), env.reward_manager.get_term_cfg
    params = of_reward("object_goal_tracking").params
    for change in ("nothing", "the object", "the goal", "a step", "a reset"):
        if change == "the object":
            _put(env, 0.3, 0)
        elif change == "the goal":
            term.command[:, :3] += torch.tensor([0.1, -0.2, 0.05])
        elif change == "a step":
            env.step(torch.zeros(3, 8))
        elif change == "a reset":
            env.reset()
        offset = env.scene["object"].data.root_pos_w - env.scene["robot"].data.root_pos_w - term.command[:, :3]
        expected = offset.norm(dim=1)  # the robot's root is not turned
        torch.testing.assert_close(object_position_error(env, "object_pose"), expected, atol=1e-6, rtol=0)
        lifted = env.scene["object"].data.root_pos_w[:, 2] > params["minimal_height"]
        reward = of_reward("object_goal_tracking").func(env, **params)
        torch.testing.assert_close(reward, lifted * (1.0 - torch.tanh(expected / params["std"])), atol=1e-5, rtol=0)


def test_a_step_computes_the_distance_to_the_goal_once_for_rewards_and_metrics(env, monkeypatch):
    calls, norm = [], torch.linalg.vector_norm

    def count(offset, *args, **kwargs):
        calls.append(offset)
        return norm(offset, *args, **kwargs)

    monkeypatch.setattr(torch.linalg, "vector_norm", count)
    env.step(torch.zeros(3, 8))
    goals = env.scene["object"].data.root_pos_w - env.command_manager.get_term("object_pose").goal_pos_w
    assert sum(torch.equal(offset, goals) for offset in calls) == 1
