"""Command terms: where they are drawn from, in which frame, and what they log."""

import math
from types import SimpleNamespace

import pytest
import torch
from scipy.spatial.transform import Rotation

import lift_lab.envs.mdp as mdp
from lift_lab.managers import MetricsManager
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.string import resolve_matching_names

NUM_ENVS = 400


def _random_quats(count: int, seed: int) -> torch.Tensor:
    xyzw = Rotation.random(count, random_state=seed).as_quat()
    return torch.tensor(xyzw[:, [3, 0, 1, 2]], dtype=torch.float32)


def _rotation(wxyz: torch.Tensor) -> Rotation:
    return Rotation.from_quat(wxyz[:, [1, 2, 3, 0]].double().numpy())


class _Robot:
    """A robot whose root and one other body stand anywhere."""

    body_names = ("base", "hand")

    def __init__(self):
        torch.manual_seed(5)
        yaw = torch.rand(NUM_ENVS) * 6 - 3
        zero = torch.zeros(NUM_ENVS)
        self.data = SimpleNamespace(
            root_pos_w=torch.randn(NUM_ENVS, 3),
            root_quat_w=_random_quats(NUM_ENVS, 1),
            body_pos_w=torch.randn(NUM_ENVS, 2, 3),
            body_quat_w=torch.stack((_random_quats(NUM_ENVS, 2), _random_quats(NUM_ENVS, 3)), dim=1),
            root_lin_vel_b=torch.tensor([[1.0, 0.0, 0.0]]).repeat(NUM_ENVS, 1),
            root_ang_vel_b=torch.tensor([[0.0, 0.0, 0.5]]).repeat(NUM_ENVS, 1),
            default_root_state=torch.tensor([[0.0, 0.0, 0.6] + [0.0] * 10]).repeat(NUM_ENVS, 1),
            heading_w=yaw,
            root_is_aligned=False,
        )
        self.data.link_pose_of = lambda body: (self.data.body_pos_w[:, body], self.data.body_quat_w[:, body])
        self.yaw_quat = torch.stack((torch.cos(yaw / 2), zero, zero, torch.sin(yaw / 2)), dim=-1)

    def find_bodies(self, keys, preserve_order=False):
        return resolve_matching_names(keys, self.body_names, preserve_order)


@pytest.fixture
def env():
    origins = torch.arange(NUM_ENVS)[:, None] * torch.tensor([3.0, 0.0, 0.0])

    class _Scene(dict):
        env_origins = origins

    return SimpleNamespace(
        num_envs=NUM_ENVS,
        device="cpu",
        step_dt=0.02,
        scene=_Scene(robot=_Robot()),
        prefetched={},
        step_cache=None,
        physics_failed=None,
    )


def _metrics(env, command) -> MetricsManager:
    """The metrics that come with a command called "goal"."""
    env.command_manager = SimpleNamespace(
        active_terms=["goal"], get_term=lambda name: command, get_command=lambda name: command.command
    )
    return MetricsManager(None, env)


def _pose_cfg(**kwargs) -> mdp.UniformPoseCommandCfg:
    ranges = mdp.UniformPoseCommandCfg.Ranges(
        pos_x=(0.4, 0.6), pos_y=(-0.25, 0.25), pos_z=(0.25, 0.5), roll=(-0.5, 0.5), pitch=(3.1, 3.2), yaw=(-3.0, 3.0)
    )
    return mdp.UniformPoseCommandCfg(
        asset_name="robot", body_name="hand", resampling_time_range=(4.0, 5.0), ranges=ranges, **kwargs
    )


def test_poses_fill_their_ranges_in_the_root_frame(env):
    command = mdp.UniformPoseCommand(_pose_cfg(), env)
    command.reset()
    position = command.command[:, :3]
    low, high = torch.tensor([0.4, -0.25, 0.25]), torch.tensor([0.6, 0.25, 0.5])
    assert ((position >= low) & (position <= high)).all()
    torch.testing.assert_close(position.mean(0), (low + high) / 2, atol=0.03, rtol=0)
    torch.testing.assert_close(position.std(0), (high - low) / math.sqrt(12), atol=0.02, rtol=0)
    yaw_pitch_roll = torch.tensor(_rotation(command.command[:, 3:]).as_euler("ZYX"))
    # a pitch of more than 90 degrees reads as another triple: undo it
    yaw, pitch, roll = yaw_pitch_roll.unbind(1)
    flipped = torch.stack((torch.pi - pitch, torch.remainder(roll + 2 * torch.pi, 2 * torch.pi) - torch.pi), dim=-1)
    assert flipped[:, 0].min() > 3.1 - 1e-3
    assert flipped[:, 0].max() < 3.2 + 1e-3
    assert flipped[:, 1].abs().max() < 0.5 + 1e-3
    assert yaw.std() > 1.0
    assert ((command.time_left >= 4.0) & (command.time_left <= 5.0)).all()


def test_a_unique_quaternion_has_a_positive_real_part(env):
    command = mdp.UniformPoseCommand(_pose_cfg(make_quat_unique=True), env)
    command.reset()
    assert (command.command[:, 3] >= 0).all()
    loose = mdp.UniformPoseCommand(_pose_cfg(), env)
    loose.reset()
    assert (loose.command[:, 3] < 0).any()


@pytest.mark.parametrize("who", ["a subclass", "a script"])
def test_a_command_that_somebody_else_wrote_is_where_the_world_looks_for_it(env, who):
    """As Isaac Lab, whose terms find the goal in the world anew at every step."""
    wanted_b = torch.tensor([0.5, 0.1, 0.9, 1.0, 0.0, 0.0, 0.0])

    class Own(mdp.UniformPoseCommand):
        def _resample_command(self, env_ids):
            self.pose_command_b[env_ids] = wanted_b

    command = (Own if who == "a subclass" else mdp.UniformPoseCommand)(_pose_cfg(), env)
    command.reset()
    if who == "a script":
        command.compute(0.02)
        command.pose_command_b[:] = wanted_b
    command.compute(0.02)
    data = env.scene["robot"].data
    wanted_w = torch.tensor(_rotation(data.root_quat_w).apply(wanted_b[:3].numpy())) + data.root_pos_w
    torch.testing.assert_close(command.pose_command_w[:, :3].double(), wanted_w, atol=1e-5, rtol=0)


@pytest.mark.parametrize("aligned", [True, False])
def test_pose_metrics_are_the_distance_and_angle_to_the_body(env, aligned):
    robot = env.scene["robot"]
    command = mdp.UniformPoseCommand(_pose_cfg(), env)
    metrics = _metrics(env, command)
    command.reset()
    robot.data.root_pos_w = robot.data.root_pos_w + 0.3
    robot.data.root_is_aligned = aligned
    robot.data.root_quat_w = _identity() if aligned else _random_quats(NUM_ENVS, 9)
    metrics.compute()
    root, wanted_b = _rotation(robot.data.root_quat_w), command.command
    wanted_pos = torch.tensor(root.apply(wanted_b[:, :3].double().numpy())) + robot.data.root_pos_w
    distance = (wanted_pos - robot.data.body_pos_w[:, 1]).norm(dim=1)
    between = (root * _rotation(wanted_b[:, 3:])).inv() * _rotation(robot.data.body_quat_w[:, 1])
    angle = torch.tensor(between.magnitude())
    position_error = metrics.episode_value("goal/position_error").double()
    orientation_error = metrics.episode_value("goal/orientation_error").double()
    torch.testing.assert_close(position_error, distance, atol=1e-5, rtol=0)
    torch.testing.assert_close(orientation_error, angle, atol=2e-3, rtol=0)
    small = angle < 2.5
    torch.testing.assert_close(orientation_error[small], angle[small], atol=1e-5, rtol=0)
    command.compute(0.02)
    torch.testing.assert_close(command.pose_command_w[:, :3].double(), wanted_pos, atol=1e-5, rtol=0)
    log = metrics.reset(torch.tensor([3, 7]))
    assert list(log) == ["Metrics/goal/position_error", "Metrics/goal/orientation_error"]
    assert float(log["Metrics/goal/position_error"]) == pytest.approx(float(distance[[3, 7]].mean()), abs=1e-5)


def _identity() -> torch.Tensor:
    return torch.tensor([[1.0, 0.0, 0.0, 0.0]]).repeat(NUM_ENVS, 1)


def test_the_goal_is_where_a_moving_robot_and_a_written_command_put_it_at_once(env):
    robot, command = env.scene["robot"], mdp.UniformPoseCommand(_pose_cfg(), env)
    command.reset()
    robot.data.root_pos_w += torch.tensor([1.0, -2.0, 0.5])
    expected = robot.data.root_pos_w.double() + torch.tensor(
        _rotation(robot.data.root_quat_w).apply(command.command[:, :3].double().numpy())
    )
    torch.testing.assert_close(command.goal_pos_w.double(), expected, atol=1e-5, rtol=0)
    command.command[:, :3] = 0.0
    torch.testing.assert_close(command.goal_pos_w, robot.data.root_pos_w)


def test_metrics_of_a_subclass_in_isaac_labs_way_are_logged_in_place_of_those_of_the_class(env):
    class Own(mdp.UniformPoseCommand):
        def __init__(self, cfg, env):
            super().__init__(cfg, env)
            self.metrics["position_error"] = torch.zeros(NUM_ENVS)

        def _update_metrics(self):
            super()._update_metrics()
            self.metrics["position_error"] = torch.full((NUM_ENVS,), 7.0)

    command = Own(_pose_cfg(), env)
    command.reset()
    command.compute(0.02)
    assert _metrics(env, command).active_terms == ["goal/orientation_error"]
    assert {name: float(value) for name, value in command.reset().items()} == {"position_error": 7.0}


def test_only_due_commands_are_drawn_anew(env):
    command = mdp.UniformPoseCommand(_pose_cfg(), env)
    command.reset()
    before = command.command.clone()
    command.time_left[:] = 1.0
    command.time_left[2] = 0.02
    command.compute(0.02)
    changed = (command.command != before).any(dim=1).nonzero().flatten()
    assert changed.tolist() == [2]
    assert command.command_counter[2] == 2


def test_ranges_may_change_between_two_draws(env):
    command = mdp.UniformPoseCommand(_pose_cfg(), env)
    command.reset()
    command.cfg.ranges.pos_x = (1.0, 1.0)
    command.reset()
    torch.testing.assert_close(command.command[:, 0], torch.ones(NUM_ENVS))


def test_a_pose_command_needs_one_body(env):
    cfg = _pose_cfg()
    cfg.body_name = ".*"
    with pytest.raises(ConfigError, match="base"):
        mdp.UniformPoseCommand(cfg, env)


def _velocity_cfg(**kwargs) -> mdp.UniformVelocityCommandCfg:
    ranges = mdp.UniformVelocityCommandCfg.Ranges(
        lin_vel_x=(1.0, 2.0), lin_vel_y=(-0.5, 0.5), ang_vel_z=(-0.8, 0.8), heading=kwargs.pop("heading", None)
    )
    return mdp.UniformVelocityCommandCfg(asset_name="robot", resampling_time_range=(2.0, 10.0), ranges=ranges, **kwargs)


def test_velocities_fill_their_ranges_and_some_environments_stand(env):
    command = mdp.UniformVelocityCommand(_velocity_cfg(rel_standing_envs=0.3), env)
    command.reset()
    command.compute(0.02)
    standing = command.is_standing_env
    assert 0.2 < standing.float().mean() < 0.4
    assert (command.command[standing] == 0).all()
    moving = command.command[~standing]
    assert moving[:, 0].min() >= 1.0
    assert moving[:, 0].max() <= 2.0
    assert moving[:, 2].abs().max() <= 0.8


def test_a_heading_command_steers_towards_the_heading(env):
    cfg = _velocity_cfg(heading_command=True, heading=(-3.0, 3.0), heading_control_stiffness=0.5)
    command = mdp.UniformVelocityCommand(cfg, env)
    command.reset()
    command.compute(0.02)
    heading = env.scene["robot"].data.heading_w
    error = torch.atan2(torch.sin(command.heading_target - heading), torch.cos(command.heading_target - heading))
    torch.testing.assert_close(command.command[:, 2], (0.5 * error).clamp(-0.8, 0.8), atol=1e-5, rtol=0)


def test_an_environment_without_a_heading_keeps_the_yaw_rate_that_was_drawn(env):
    cfg = _velocity_cfg(heading_command=True, heading=(-3.0, 3.0), rel_heading_envs=0.5)
    command = mdp.UniformVelocityCommand(cfg, env)
    command.reset()
    drawn = command.command[:, 2].clone()
    command.compute(0.02)
    kept = command.command[:, 2] == drawn
    assert torch.equal(kept, ~command.is_heading_env)
    assert 0.35 < kept.float().mean() < 0.65


def test_velocity_metrics_sum_the_error_over_the_steps_that_a_command_can_last(env):
    command = mdp.UniformVelocityCommand(_velocity_cfg(), env)
    metrics = _metrics(env, command)
    command.reset()
    command.vel_command_b[:] = torch.tensor([4.0, 4.0, 1.5])
    for _ in range(50):
        metrics.compute()
    # error (3, 4) and 1, for 50 of the 500 steps that a command can last
    log = metrics.reset()
    assert {name: float(value) for name, value in log.items()} == pytest.approx(
        {"Metrics/goal/error_vel_xy": 0.5, "Metrics/goal/error_vel_yaw": 0.1}, abs=1e-4
    )


def test_a_heading_command_without_a_range_is_an_error(env):
    with pytest.raises(ConfigError, match="heading_command=True"):
        mdp.UniformVelocityCommand(_velocity_cfg(heading_command=True), env)


def test_normal_velocities_have_their_moments_and_zeros(env):
    ranges = mdp.NormalVelocityCommandCfg.Ranges(
        mean_vel=(2.0, 1.0, 0.0), std_vel=(0.1, 0.2, 0.3), zero_prob=(0.0, 0.5, 0.0)
    )
    cfg = mdp.NormalVelocityCommandCfg(asset_name="robot", resampling_time_range=(2.0, 2.0), ranges=ranges)
    command = mdp.NormalVelocityCommand(cfg, env)
    command.reset()
    command.compute(0.02)
    x, y = command.command[:, 0], command.command[:, 1]
    torch.testing.assert_close(x.abs().mean(), torch.tensor(2.0), atol=0.03, rtol=0)
    torch.testing.assert_close(x.abs().std(), torch.tensor(0.1), atol=0.02, rtol=0)
    assert 0.4 < (x > 0).float().mean() < 0.6
    assert 0.4 < (y == 0).float().mean() < 0.6


def _pose_2d_cfg(simple_heading: bool) -> mdp.UniformPose2dCommandCfg:
    ranges = mdp.UniformPose2dCommandCfg.Ranges(pos_x=(-2.0, 2.0), pos_y=(1.0, 3.0), heading=(0.5, 1.0))
    return mdp.UniformPose2dCommandCfg(
        asset_name="robot", resampling_time_range=(9.0, 9.0), simple_heading=simple_heading, ranges=ranges
    )


def test_a_ground_pose_is_drawn_about_the_origin_and_seen_from_the_root(env):
    robot = env.scene["robot"]
    leaning = (_rotation(robot.yaw_quat) * Rotation.from_euler("x", 0.4)).as_quat()[:, [3, 0, 1, 2]]
    robot.data.root_quat_w = torch.tensor(leaning, dtype=torch.float32)
    command = mdp.UniformPose2dCommand(_pose_2d_cfg(simple_heading=False), env)
    command.reset()
    command.compute(0.02)
    offset = command.pos_command_w - env.scene.env_origins
    assert offset[:, 0].abs().max() <= 2.0
    assert offset[:, 1].min() >= 1.0
    torch.testing.assert_close(offset[:, 2], torch.full((NUM_ENVS,), 0.6))
    seen = _rotation(robot.yaw_quat).inv().apply((command.pos_command_w - robot.data.root_pos_w).double().numpy())
    torch.testing.assert_close(command.command[:, :3].double(), torch.tensor(seen), atol=1e-3, rtol=0)
    turn = command.heading_command_w - robot.data.heading_w
    torch.testing.assert_close(torch.cos(command.command[:, 3]), torch.cos(turn), atol=1e-5, rtol=0)
    torch.testing.assert_close(torch.sin(command.command[:, 3]), torch.sin(turn), atol=1e-5, rtol=0)
    metrics = _metrics(env, command)
    metrics.compute()
    error = metrics.episode_value("goal/error_heading")
    torch.testing.assert_close(error, torch.acos(torch.cos(turn)), atol=2e-3, rtol=0)
    distance = torch.hypot(*(command.pos_command_w - robot.data.root_pos_w)[:, :2].unbind(1))
    torch.testing.assert_close(metrics.episode_value("goal/error_pos_2d"), distance)


def test_a_simple_heading_lies_along_the_way_and_needs_no_more_than_a_quarter_turn(env):
    command = mdp.UniformPose2dCommand(_pose_2d_cfg(simple_heading=True), env)
    command.reset()
    command.compute(0.02)
    way = command.pos_command_w - env.scene["robot"].data.root_pos_w
    across = torch.sin(command.heading_command_w) * way[:, 0] - torch.cos(command.heading_command_w) * way[:, 1]
    torch.testing.assert_close(across, torch.zeros(NUM_ENVS), atol=1e-2, rtol=0)
    assert command.command[:, 3].abs().max() <= math.pi / 2 + 1e-5


def test_a_null_command_has_nothing_to_read(env):
    command = mdp.NullCommand(mdp.NullCommandCfg(), env)
    assert command.reset() == {}
    command.compute(0.02)
    with pytest.raises(RuntimeError):
        _ = command.command
