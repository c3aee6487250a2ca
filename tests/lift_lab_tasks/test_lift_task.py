"""The lift task: sizes, rewards at known states, resets, curriculum, repeatability and failures of the engine."""

import math

import pytest
import torch

from lift_lab.envs import ManagerBasedRLEnv
from lift_lab_tasks.manager_based.manipulation.lift import mdp
from lift_lab_tasks.manager_based.manipulation.lift.config.franka.joint_pos_env_cfg import (
    FrankaCubeLiftCurriculumEnvCfg,
    FrankaCubeLiftEnvCfg,
    FrankaCubeLiftEnvCfg_PLAY,
)

PHYSICS = ["native", pytest.param("warp", marks=pytest.mark.slow)]


def _make(cfg_type=FrankaCubeLiftEnvCfg, num_envs=4, physics="native", seed=3, **sim) -> ManagerBasedRLEnv:
    cfg = cfg_type()
    cfg.scene.num_envs = num_envs
    cfg.sim.device = "cpu"
    cfg.sim.physics = physics
    cfg.seed = seed
    for name, value in sim.items():
        setattr(cfg.sim, name, value)
    return ManagerBasedRLEnv(cfg)


@pytest.mark.parametrize("physics", PHYSICS)
def test_sizes_are_isaac_labs_and_random_actions_keep_everything_finite(physics):
    env = _make(physics=physics)
    obs, _ = env.reset()
    assert obs["policy"].shape == (4, 36)
    assert env.action_manager.total_action_dim == 8
    assert env.max_episode_length == 250
    for _ in range(30):
        obs, reward, terminated, truncated, _ = env.step(torch.randn(4, 8))
        assert obs["policy"].isfinite().all()
        assert reward.isfinite().all()
    assert not (terminated | truncated).any()
    env.close()


@pytest.mark.parametrize("physics", PHYSICS)
def test_rewards_at_a_known_state_are_the_papers_equations(physics):
    env = _make(physics=physics, num_envs=2)
    env.reset()
    cube, robot = env.scene["object"], env.scene["robot"]
    goal_b = torch.tensor([[0.5, 0.1, 0.4], [0.45, -0.2, 0.3]])
    env.command_manager.get_command("object_pose")[:, :3] = goal_b
    offset = torch.tensor([[0.0, 0.03, 0.04], [0.0, 0.0, -0.29]])
    pose = torch.tensor([[0.0, 0, 0, 1, 0, 0, 0]]).repeat(2, 1)
    pose[:, :3] = goal_b + offset + env.scene.env_origins
    cube.write_root_pose_to_sim(pose)
    env.sim.physics.refresh()
    env.scene.update(0.0)

    # 0.05 m and 0.29 m away; the second cube lies at 0.01 m, below the threshold
    lifted = mdp.object_is_lifted(env, minimal_height=0.04)
    torch.testing.assert_close(lifted, torch.tensor([1.0, 0.0]))
    coarse = mdp.object_goal_distance(env, std=0.3, minimal_height=0.04, command_name="object_pose")
    torch.testing.assert_close(coarse, torch.tensor([1 - math.tanh(0.05 / 0.3), 0.0]), atol=1e-5, rtol=0)
    fine = mdp.object_goal_distance(env, std=0.05, minimal_height=0.04, command_name="object_pose")
    torch.testing.assert_close(fine, torch.tensor([1 - math.tanh(1.0), 0.0]), atol=1e-5, rtol=0)
    printed = mdp.object_goal_distance(env, std=0.3, minimal_height=None, command_name="object_pose")
    torch.testing.assert_close(printed[1], torch.tensor(1 - math.tanh(0.29 / 0.3)), atol=1e-5, rtol=0)
    tool = env.scene["ee_frame"].data.target_pos_w[:, 0]
    distance = (tool - pose[:, :3]).double().pow(2).sum(1).sqrt()
    reach = mdp.object_ee_distance(env, std=0.1)
    torch.testing.assert_close(reach.double(), 1 - torch.tanh(distance / 0.1), atol=1e-5, rtol=0)
    assert mdp.object_reached_goal(env, threshold=0.06).tolist() == [True, False]
    position = mdp.object_position_in_robot_root_frame(env)
    torch.testing.assert_close(position, goal_b + offset, atol=1e-5, rtol=0)
    assert robot.is_fixed_base
    env.close()


@pytest.mark.parametrize("angle", [0.0, 0.5 * math.pi, 2.0])
def test_a_base_that_stands_turned_takes_its_frame_along(angle):
    cfg = FrankaCubeLiftEnvCfg()
    cfg.scene.num_envs, cfg.sim.device, cfg.seed = 4, "cpu", 5
    cfg.scene.robot.init_state.pos = (0.1, -0.2, 0.0)
    cfg.scene.robot.init_state.rot = (math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle))
    env = ManagerBasedRLEnv(cfg)
    env.reset()
    env.step(torch.zeros(4, 8))
    base_w = env.scene.env_origins + torch.tensor([0.1, -0.2, 0.0])
    c, s = math.cos(angle), math.sin(angle)
    to_world = torch.tensor([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    cube_w = env.scene["object"].data.root_pos_w
    position_b = mdp.object_position_in_robot_root_frame(env)
    torch.testing.assert_close(position_b @ to_world.T + base_w, cube_w, atol=1e-5, rtol=0)
    goal = env.command_manager.get_term("object_pose")
    goal_w = goal.command[:, :3] @ to_world.T + base_w
    torch.testing.assert_close(goal.goal_pos_w, goal_w, atol=1e-5, rtol=0)
    half_turn = torch.tensor([math.cos(0.5 * angle), 0.0, 0.0, math.sin(0.5 * angle)])
    torch.testing.assert_close(goal.pose_command_w[:, 3:], half_turn.repeat(4, 1), atol=1e-6, rtol=0)
    torch.testing.assert_close(
        mdp.object_position_error(env, "object_pose"), (cube_w - goal_w).norm(dim=1), atol=1e-5, rtol=0
    )
    env.close()


def test_the_rewards_sum_to_at_most_37_a_second():
    env = _make(num_envs=1)
    positive = [
        env.reward_manager.get_term_cfg(name).weight
        for name in env.reward_manager.active_terms
        if env.reward_manager.get_term_cfg(name).weight > 0
    ]
    assert sum(positive) == 37.0
    env.close()


def test_a_reset_spreads_cube_and_goal_over_the_tasks_ranges():
    env = _make(num_envs=512)
    env.reset()
    cube_e = env.scene["object"].data.root_pos_w - env.scene.env_origins
    goal_b = env.command_manager.get_command("object_pose")[:, :3]
    for values, low, high in (
        (cube_e[:, 0], 0.4, 0.6),
        (cube_e[:, 1], -0.25, 0.25),
        (goal_b[:, 0], 0.4, 0.6),
        (goal_b[:, 1], -0.25, 0.25),
        (goal_b[:, 2], 0.25, 0.5),
    ):
        width = high - low
        assert values.min() >= low - 1e-5
        assert values.max() <= high + 1e-5
        # the extremes of 512 uniform samples are within 3 % of the ends but once in 10^7
        assert values.min() < low + 0.03 * width
        assert values.max() > high - 0.03 * width
    torch.testing.assert_close(cube_e[:, 2], torch.full((512,), 0.02), atol=1e-6, rtol=0)
    env.close()


def test_a_cube_that_falls_off_the_table_ends_the_episode():
    env = _make()
    env.reset()
    pose = env.scene["object"].data.root_pose_w.clone()
    pose[1, :3] = env.scene.env_origins[1] + torch.tensor([0.5, 0.0, -0.2])
    env.scene["object"].write_root_pose_to_sim(pose)
    _, _, terminated, truncated, extras = env.step(torch.zeros(4, 8))
    assert terminated.tolist() == [False, True, False, False]
    assert not truncated.any()
    assert float(extras["log"]["Episode_Termination/object_dropping"]) == pytest.approx(0.25)
    env.close()


def test_an_episode_of_five_seconds_is_truncated():
    env = _make()
    env.reset()
    env.episode_length_buf[:] = 248
    _, _, _, truncated, _ = env.step(torch.zeros(4, 8))
    assert not truncated.any()
    _, _, terminated, truncated, _ = env.step(torch.zeros(4, 8))
    assert truncated.all()
    assert not terminated.any()
    env.close()


def test_the_curriculum_raises_the_penalties_after_its_step():
    env = _make(FrankaCubeLiftCurriculumEnvCfg)
    env.reset()
    step = env.curriculum_manager.get_term_cfg("joint_vel").params["num_steps"]
    before = env.reward_manager.get_term_cfg("joint_vel").weight
    env.common_step_counter = step
    env.reset()
    assert env.reward_manager.get_term_cfg("joint_vel").weight == before == -1e-4
    env.common_step_counter = step + 1
    env.reset()
    assert env.reward_manager.get_term_cfg("joint_vel").weight == -1e-1
    assert env.reward_manager.get_term_cfg("action_rate").weight == -1e-1
    env.close()


def test_the_play_task_has_fifty_environments_without_noise():
    cfg = FrankaCubeLiftEnvCfg_PLAY()
    assert cfg.scene.num_envs == 50
    assert not cfg.observations.policy.enable_corruption


def _rollout(num_threads: int) -> torch.Tensor:
    env = _make(num_envs=16, seed=5, num_threads=num_threads)
    obs, _ = env.reset()
    generator = torch.Generator().manual_seed(0)
    history = []
    for _ in range(40):
        obs, reward, *_ = env.step(torch.randn(16, 8, generator=generator))
        history.append(torch.cat((obs["policy"], reward[:, None]), dim=1))
    env.close()
    return torch.stack(history)


def test_one_seed_gives_the_same_bits_at_any_number_of_threads():
    first = _rollout(1)
    assert torch.equal(first, _rollout(1))
    assert torch.equal(first, _rollout(2))


@pytest.mark.parametrize("physics", PHYSICS)
def test_a_broken_environment_is_reset_counted_and_hidden_from_the_policy(physics):
    env = _make(physics=physics)
    env.reset()
    env.step(torch.zeros(4, 8))
    broken = torch.tensor([2])
    env.sim.physics.write("qvel", torch.full((1, 9), float("nan")), broken, slice(0, 9))
    obs, reward, terminated, _, extras = env.step(torch.zeros(4, 8))
    assert obs["policy"].isfinite().all()
    assert reward.isfinite().all()
    assert terminated.tolist() == [False, False, True, False]
    assert float(reward[2]) == 0.0
    assert float(extras["log"]["Metrics/physics/nonfinite"]) == 1.0
    obs, _, terminated, _, _ = env.step(torch.zeros(4, 8))
    assert obs["policy"].isfinite().all()
    assert not terminated.any()
    env.close()
