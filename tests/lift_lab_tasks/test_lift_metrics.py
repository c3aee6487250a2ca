"""What the lift task measures of an episode for the study's report."""

from itertools import pairwise

import pytest
import torch

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab_tasks.manager_based.manipulation.lift.config.franka.joint_pos_env_cfg import FrankaCubeLiftEnvCfg


@pytest.fixture(scope="module")
def env():
    cfg = FrankaCubeLiftEnvCfg()
    cfg.scene.num_envs, cfg.sim.device, cfg.seed = 3, "cpu", 1
    made = ManagerBasedRLEnv(cfg)
    yield made
    made.close()


def _put(env, height_m, index):
    """Put one environment's cube over its start, at a height."""
    pose = env.scene["object"].data.root_pose_w.clone()
    pose[index, :3] = env.scene.env_origins[index] + torch.tensor([0.5, 0.0, height_m])
    env.scene["object"].write_root_pose_to_sim(pose)
    env.scene["object"].write_root_velocity_to_sim(torch.zeros(env.num_envs, 6))
    env.sim.physics.refresh()


def test_smoothness_is_the_mean_over_the_steps_of_an_episode(env):
    env.reset()
    term = env.command_manager.get_term("object_pose")
    arm = slice(0, 7)
    actions = [0.1 * torch.randn(3, 8) for _ in range(4)]
    speeds = [env.scene["robot"].data.joint_vel[:, arm].clone()]
    for action in actions:
        env.step(action)
        speeds.append(env.scene["robot"].data.joint_vel[:, arm].clone())
    changes = [(b - a).square().sum(1) for a, b in pairwise([torch.zeros(3, 8), *actions])]
    torch.testing.assert_close(term.metrics["squared_action_change"], torch.stack(changes).mean(0))
    accelerations = [((b - a) / 0.02).square().mean(1) for a, b in pairwise(speeds)]
    torch.testing.assert_close(term.metrics["squared_joint_acceleration"], torch.stack(accelerations).mean(0))


def test_time_to_success_counts_only_episodes_that_succeeded(env):
    env.reset()
    term = env.command_manager.get_term("object_pose")
    for _ in range(3):
        env.step(torch.zeros(3, 8))
    term.pose_command_w[1, :3] = env.scene["object"].data.root_pos_w[1]
    for _ in range(2):
        env.step(torch.zeros(3, 8))
    assert term.metrics["success"].tolist() == [0.0, 1.0, 0.0]
    log = term.reset(torch.tensor([0, 1]))
    assert float(log["time_to_success_s"]) == pytest.approx(4 * 0.02)
    counts = term.log_counts
    assert set(counts) == set(log)
    assert counts.pop("time_to_success_s") == 1  # of those that end, one succeeded
    assert set(counts.values()) == {2}
    assert float(log["success"]) == 0.5
    assert "time_to_success_s" not in term.reset(torch.tensor([1, 2]))


def test_a_first_pick_is_dropped_when_the_object_was_held_up_and_lies_again(env):
    env.reset()
    term = env.command_manager.get_term("object_pose")
    for height in (0.3, 0.05, 0.02):  # held, lower but not down, down
        _put(env, height, 0)
        env.step(torch.zeros(3, 8))
        if height > 0.02:
            assert term.metrics["first_pick_drop"].tolist() == [0.0, 0.0, 0.0]
    assert term.metrics["first_pick_drop"].tolist() == [1.0, 0.0, 0.0]
    _put(env, 0.05, 1)  # never above 0.06 m: not a pick
    env.step(torch.zeros(3, 8))
    _put(env, 0.02, 1)
    env.step(torch.zeros(3, 8))
    assert term.metrics["first_pick_drop"].tolist() == [1.0, 0.0, 0.0]
