"""Event terms on a real scene: what they draw and which environments they touch."""

import pytest
import torch

import lift_lab.envs.mdp as mdp
import lift_lab.sim as sim_utils
from lift_lab.envs import ManagerBasedEnv
from lift_lab.managers import EventTermCfg, SceneEntityCfg
from lift_lab.sim import ignored
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.math import quat_apply

BALL = SceneEntityCfg("ball")
ROBOT = SceneEntityCfg("robot")


@pytest.fixture
def env(make_env):
    """Enough environments to see a distribution."""
    env = make_env(num_envs=200)
    env.reset(seed=5)
    return env


def _class_term(func, env, **params):
    term = func(EventTermCfg(func=func, mode="startup", params=params), env)
    term(env, params.pop("env_ids", None), **params)
    return term


def test_a_default_reset_brings_back_state_and_targets(env):
    robot, ball = env.scene["robot"], env.scene["ball"]
    robot.write_joint_state_to_sim(robot.data.joint_pos + 0.2, robot.data.joint_vel + 1.0)
    robot.set_joint_position_target(robot.data.joint_pos.clone())
    robot.set_joint_velocity_target(torch.ones(env.num_envs, 2))
    ball.write_root_pose_to_sim(ball.data.root_pose_w + 0.1)
    ball.write_root_velocity_to_sim(torch.ones(env.num_envs, 6))
    ids = torch.tensor([1, 4])
    mdp.reset_scene_to_default(env, ids, reset_joint_targets=True)
    torch.testing.assert_close(robot.data.joint_pos[ids], robot.data.default_joint_pos[ids])
    torch.testing.assert_close(robot.data.joint_vel[ids], torch.zeros(2, 2))
    torch.testing.assert_close(robot.data.joint_pos_target[ids], robot.data.default_joint_pos[ids])
    assert robot.data.joint_vel_target[:6, 0].tolist() == [1.0, 0.0, 1.0, 1.0, 0.0, 1.0]
    home = torch.tensor([2.0, 0.0, 1.0]) + env.scene.env_origins
    torch.testing.assert_close(ball.data.root_pos_w[ids], home[ids])
    torch.testing.assert_close(ball.data.root_vel_w[ids], torch.zeros(2, 6))
    assert (ball.data.root_pos_w - home)[[0, 2, 3, 5]].abs().min() > 0.05
    assert (robot.data.joint_vel[[0, 2, 3, 5]] == 1.0).all()


def test_a_default_reset_brings_back_a_kinematic_articulation(make_env, make_cfg):
    cfg = make_cfg()
    cfg.scene.robot.spawn.rigid_props = sim_utils.RigidBodyPropertiesCfg(kinematic_enabled=True)
    env = make_env(cfg=cfg)
    robot = env.scene["robot"]
    pose = robot.data.root_pose_w.clone()
    robot.write_root_pose_to_sim(pose + torch.tensor([0.3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    mdp.reset_scene_to_default(env, torch.tensor([1]))
    moved = (robot.data.root_pose_w - pose)[:, 0]
    torch.testing.assert_close(moved, torch.tensor([0.3, 0.0, 0.3]))


def test_a_root_is_reset_uniformly_about_its_default_pose(env):
    ball = env.scene["ball"]
    ball.data.default_root_state[:, 8] = 3.0
    for _ in range(2):  # from the defaults each time
        mdp.reset_root_state_uniform(
            env, None, {"x": (-0.1, 0.3), "z": (0.5, 0.5)}, {"y": (1.0, 2.0), "yaw": (-1.0, 1.0)}, BALL
        )
    offset = ball.data.root_pos_w - env.scene.env_origins - torch.tensor([2.0, 0.0, 1.0])
    assert offset[:, 0].min() >= -0.1 - 1e-5
    assert offset[:, 0].max() <= 0.3 + 1e-5
    assert abs(offset[:, 0].mean() - 0.1) < 0.03
    torch.testing.assert_close(offset[:, 1:], torch.tensor([[0.0, 0.5]]).repeat(len(offset), 1), atol=1e-5, rtol=0)
    torch.testing.assert_close(ball.data.root_quat_w, torch.tensor([[1.0, 0.0, 0.0, 0.0]]).repeat(len(offset), 1))
    velocity = ball.data.root_vel_w
    assert velocity[:, 1].min() >= 4.0
    assert velocity[:, 1].max() <= 5.0
    assert velocity[:, 5].std() > 0.4
    assert (velocity[:, [0, 2, 3, 4]].abs() < 1e-5).all()


def test_a_rotation_is_applied_after_the_default_orientation(env, quarter_turn_z):
    ball = env.scene["ball"]
    ball.data.default_root_state[:, 3:7] = quarter_turn_z
    mdp.reset_root_state_uniform(env, None, {"roll": (0.4, 0.4)}, {}, BALL)
    # the body's x axis is the world's y axis, and turns about itself
    half = torch.tensor(0.2)
    turned = torch.stack((half.cos(), half.new_zeros(()), half.sin(), half.new_zeros(())))  # about world y
    w, x, y, z = turned
    a, b, c, d = quarter_turn_z
    expected = torch.stack(
        (
            w * a - x * b - y * c - z * d,
            w * b + x * a + y * d - z * c,
            w * c - x * d + y * a + z * b,
            w * d + x * c - y * b + z * a,
        )
    )
    torch.testing.assert_close(ball.data.root_quat_w[0], expected)


def test_random_orientations_cover_all_rotations(env):
    mdp.reset_root_state_with_random_orientation(env, None, {"x": (0.2, 0.2)}, {}, BALL)
    place = env.scene["ball"].data.root_pos_w - env.scene.env_origins
    torch.testing.assert_close(place, torch.tensor([2.2, 0.0, 1.0]).expand_as(place), atol=1e-5, rtol=0)
    quat = env.scene["ball"].data.root_quat_w
    torch.testing.assert_close(quat.norm(dim=1), torch.ones(len(quat)))
    # the second moment of a uniform unit quaternion is I / 4
    torch.testing.assert_close(quat.T @ quat / len(quat), torch.eye(4) / 4, atol=0.08, rtol=0)


def test_a_misspelt_axis_is_an_error(env):
    with pytest.raises(ConfigError, match="'pitch'"):
        mdp.reset_root_state_uniform(env, None, {"ptich": (0.0, 1.0)}, {}, BALL)
    with pytest.raises(ConfigError, match="no axis 'roll'"):
        mdp.reset_root_state_with_random_orientation(env, None, {"roll": (0.0, 1.0)}, {}, BALL)


def test_joints_are_reset_by_scale_and_by_offset_within_their_limits(env):
    robot = env.scene["robot"]
    robot.data.default_joint_vel[:] = 0.4
    mdp.reset_joints_by_scale(env, None, (0.5, 1.5), (2.0, 2.0), ROBOT)
    torch.testing.assert_close(robot.data.joint_vel, torch.full((env.num_envs, 2), 0.8))
    ratio = robot.data.joint_pos / robot.data.default_joint_pos
    assert ratio.min() >= 0.5 - 1e-5
    assert ratio.max() <= 1.5 + 1e-5
    assert ratio.std() > 0.2
    elbow = SceneEntityCfg("robot", joint_names=["elbow"])
    elbow.resolve(env.scene)
    before = robot.data.joint_pos.clone()
    ids = torch.tensor([0, 3])
    robot.data.soft_joint_pos_limits[..., 1] = 1.0  # below the joints' own of 120 degrees
    robot.data.soft_joint_vel_limits[:] = 0.3
    mdp.reset_joints_by_offset(env, ids, (5.0, 6.0), (-3.0, -2.0), elbow)
    torch.testing.assert_close(robot.data.joint_pos[ids, 1], torch.ones(2))
    torch.testing.assert_close(robot.data.joint_pos[:, 0], before[:, 0])
    torch.testing.assert_close(robot.data.joint_pos[1], before[1])
    torch.testing.assert_close(robot.data.joint_vel[ids, 1], torch.full((2,), -0.3))


def test_a_push_adds_to_the_velocity(env):
    ball = env.scene["ball"]
    ball.write_root_velocity_to_sim(torch.tensor([[1.0, 0.0, 0.0, 0.0, 0.0, 2.0]]).repeat(env.num_envs, 1))
    mdp.push_by_setting_velocity(env, torch.tensor([2]), {"x": (0.5, 0.5), "yaw": (-1.0, -1.0)}, BALL)
    torch.testing.assert_close(ball.data.root_vel_w[2], torch.tensor([1.5, 0.0, 0.0, 0.0, 0.0, 1.0]))
    torch.testing.assert_close(ball.data.root_vel_w[1], torch.tensor([1.0, 0.0, 0.0, 0.0, 0.0, 2.0]))


def test_external_forces_accelerate_the_body(env):
    ball = env.scene["ball"]
    mdp.apply_external_force_torque(env, slice(1, 2), (2.0, 2.0), (0.0, 0.0), BALL)
    env.step(torch.zeros(env.num_envs, 2))
    # 2 N in each direction on 0.5 kg for 20 ms
    torch.testing.assert_close(ball.data.root_lin_vel_w[1], torch.full((3,), 0.08), atol=1e-4, rtol=0)
    torch.testing.assert_close(ball.data.root_lin_vel_w[0], torch.zeros(3), atol=1e-6, rtol=0)


def test_masses_are_drawn_from_their_defaults_each_time(env):
    ball = env.scene["ball"]
    params = {"asset_cfg": BALL, "mass_distribution_params": (0.5, 2.0), "operation": "scale"}
    term = _class_term(mdp.randomize_rigid_body_mass, env, **params)
    term(env, None, **params)
    masses = ball.get_masses()[:, 0]
    assert masses.min() >= 0.25 - 1e-6
    assert masses.max() <= 1.0 + 1e-6
    assert abs(masses.mean() - 0.625) < 0.05
    inertia = env.sim.physics.randomizable("body_inertia")[:, env.sim.model.body("ball/Ball").id]
    # a sphere: 2/5 m r^2
    expected = (0.4 * masses * 0.01)[:, None].repeat(1, 3)
    torch.testing.assert_close(inertia.float(), expected, rtol=1e-4, atol=0)
    term(env, None, **params, recompute_inertia=False)
    assert (ball.get_masses()[:, 0] - masses).abs().min() > 0.0
    torch.testing.assert_close(inertia.float(), expected, rtol=1e-4, atol=0)


def test_a_mass_of_the_chosen_bodies_is_added_to(env):
    robot = env.scene["robot"]
    lower = SceneEntityCfg("robot", body_names=["lower"])
    lower.resolve(env.scene)
    ids = torch.tensor([0, 2])
    term = mdp.randomize_rigid_body_mass(
        EventTermCfg(
            func=mdp.randomize_rigid_body_mass,
            mode="startup",
            params={"asset_cfg": lower, "mass_distribution_params": (0.3, 0.3), "operation": "add"},
        ),
        env,
    )
    term(env, ids, lower, (0.3, 0.3), "add")
    torch.testing.assert_close(
        robot.get_masses()[:3], torch.tensor([[2.0, 1.0, 0.8], [2.0, 1.0, 0.5], [2.0, 1.0, 0.8]])
    )
    term(env, ids, lower, (-3.0, -3.0), "add", min_mass=0.01)
    torch.testing.assert_close(robot.get_masses()[2, 2], torch.tensor(0.01))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"operation": "scael"}, "'scale'"),
        ({"mass_distribution_params": (0.0, 1.0)}, "above zero"),
        ({"mass_distribution_params": (2.0, 1.0)}, "low, high"),
        ({"min_mass": 0.0}, "min_mass"),
    ],
)
def test_masses_that_cannot_be_are_refused(env, changes, message):
    params = {"asset_cfg": BALL, "mass_distribution_params": (0.5, 2.0), "operation": "scale", **changes}
    with pytest.raises(ConfigError, match=message):
        mdp.randomize_rigid_body_mass(
            EventTermCfg(func=mdp.randomize_rigid_body_mass, mode="startup", params=params), env
        )


def test_friction_comes_from_a_number_of_materials(env, monkeypatch):
    monkeypatch.setattr(ignored, "_reported", set())
    monkeypatch.setattr(ignored, "_pending", {})
    _class_term(
        mdp.randomize_rigid_body_material,
        env,
        static_friction_range=(0.4, 0.9),
        dynamic_friction_range=(0.1, 0.2),
        restitution_range=(0.0, 0.5),
        num_buckets=5,
        asset_cfg=BALL,
    )
    geom = next(g for g in range(env.sim.model.ngeom) if env.sim.model.geom(g).name.startswith("ball/"))
    friction = env.sim.physics.randomizable("geom_friction")[:, geom, 0]
    assert len(friction.unique()) == 5
    assert friction.min() >= 0.4
    assert friction.max() <= 0.9
    noted = " ".join(ignored.pending_ignored())
    assert "dynamic_friction_range" in noted
    assert "restitution_range" in noted


def test_gains_are_drawn_for_the_chosen_joints(env):
    robot = env.scene["robot"]
    elbow = SceneEntityCfg("robot", joint_names=["elbow"])
    elbow.resolve(env.scene)
    params = {
        "asset_cfg": elbow,
        "stiffness_distribution_params": (2.0, 2.0),
        "damping_distribution_params": (0.5, 1.5),
        "operation": "scale",
    }
    _class_term(mdp.randomize_actuator_gains, env, **params)(env, None, **params)  # from the defaults each time
    torch.testing.assert_close(robot.data.joint_stiffness[0], torch.tensor([50.0, 100.0]))
    damping = robot.data.joint_damping
    assert (damping[:, 0] == 5.0).all()
    assert damping[:, 1].min() >= 2.5
    assert damping[:, 1].max() <= 7.5
    assert damping[:, 1].std() > 1.0
    bias = env.sim.physics.randomizable("actuator_biasprm")
    torch.testing.assert_close(bias[:, 1, 1].float(), torch.full((env.num_envs,), -100.0))
    torch.testing.assert_close(-bias[:, 1, 2].float(), damping[:, 1])
    less = {"asset_cfg": elbow, "stiffness_distribution_params": (-99.0, -99.0), "operation": "add"}
    _class_term(mdp.randomize_actuator_gains, env, **less)
    assert robot.data.joint_stiffness[0].tolist() == [50.0, 0.0]  # none is negative


def test_joint_friction_armature_and_limits_are_drawn(env):
    data = env.scene["robot"].data
    _class_term(
        mdp.randomize_joint_parameters,
        env,
        asset_cfg=ROBOT,
        friction_distribution_params=(0.1, 0.3),
        armature_distribution_params=(0.01, 0.02),
        upper_limit_distribution_params=(1.0, 1.2),
        operation="abs",
    )
    for value, low, high in (
        (data.joint_friction_coeff, 0.1, 0.3),
        (data.joint_armature, 0.01, 0.02),
        (data.joint_pos_limits[..., 1], 1.0, 1.2),
    ):
        assert value.min() >= low - 1e-6
        assert value.max() <= high + 1e-6
        assert value.std() > 0
    torch.testing.assert_close(data.joint_pos_limits[..., 0], torch.full((env.num_envs, 2), -torch.pi / 2))
    for _ in range(2):  # on top of the values at start, never of those that were drawn
        _class_term(
            mdp.randomize_joint_parameters,
            env,
            asset_cfg=ROBOT,
            armature_distribution_params=(0.05, 0.05),
            lower_limit_distribution_params=(0.1, 0.1),
            upper_limit_distribution_params=(-0.2, -0.2),
            operation="add",
        )
    torch.testing.assert_close(data.joint_armature, torch.full((env.num_envs, 2), 0.05))
    limits = torch.tensor([-torch.pi / 2 + 0.1, 2 * torch.pi / 3 - 0.2])
    torch.testing.assert_close(data.joint_pos_limits, limits.expand(env.num_envs, 2, 2))
    with pytest.raises(ConfigError, match="above its upper limit"):
        _class_term(mdp.randomize_joint_parameters, env, asset_cfg=ROBOT, lower_limit_distribution_params=(3.0, 3.0))


def test_centres_of_mass_move_alike_and_always_from_where_they_were_at_first(env):
    robot = env.scene["robot"]
    default = robot.data.body_com_pos_b.clone()
    chosen = SceneEntityCfg("robot", body_names=["upper", "lower"])
    chosen.resolve(env.scene)
    ids = torch.arange(0, env.num_envs, 2)
    params = {"com_range": {"x": (-0.1, 0.1), "z": (0.05, 0.05)}, "asset_cfg": chosen}
    for _ in range(3):  # drawn anew, never on top of the last
        _class_term(mdp.randomize_rigid_body_com, env, env_ids=ids, **params)
    shift = robot.data.body_com_pos_b - default
    assert shift[1::2].abs().max() == 0.0
    moved = shift[ids][:, chosen.body_ids]
    torch.testing.assert_close(moved[:, 0], moved[:, 1])
    assert moved[..., 0].abs().max() <= 0.1
    assert moved[..., 0].std() > 0.04
    torch.testing.assert_close(moved[..., 1:], torch.tensor([0.0, 0.05]).expand_as(moved[..., 1:]))
    env.sim.physics.refresh()
    quat = robot.data.body_quat_w
    expected = robot.data.body_pos_w + quat_apply(quat, robot.data.body_com_pos_b)
    torch.testing.assert_close(robot.data.body_com_pos_w, expected, atol=1e-5, rtol=0)


def test_a_centre_of_mass_that_was_compiled_to_stay_says_how_it_can_move(env):
    with pytest.raises(ConfigError, match="'ball': the centre of mass of 'Ball' was compiled to stay at its origin"):
        _class_term(mdp.randomize_rigid_body_com, env, com_range={"y": (0.05, 0.05)}, asset_cfg=BALL)


@pytest.mark.parametrize("physics", ["native", pytest.param("warp", marks=pytest.mark.slow)])
def test_a_moved_centre_of_mass_is_what_a_body_spins_about(make_env, physics, monkeypatch):
    monkeypatch.setattr(ManagerBasedEnv, "event_modes", None)  # this test applies a mode of its own
    params = {"com_range": {"y": (0.05, 0.05)}, "asset_cfg": BALL}
    events = {"com": EventTermCfg(func=mdp.randomize_rigid_body_com, mode="only_some", params=params)}
    env = make_env(physics=physics, events=events)
    env.reset()
    env.event_manager.apply(mode="only_some", env_ids=torch.tensor([0]))
    ball = env.scene["ball"]
    before = ball.data.root_link_pose_w.clone()
    velocity = torch.tensor([[0.0, 0.0, 0.0, 0.0, 0.0, 3.0]]).repeat(env.num_envs, 1)
    ball.write_root_velocity_to_sim(velocity)
    torch.testing.assert_close(ball.data.root_com_vel_w, velocity, atol=1e-5, rtol=0)
    # about the centre of mass, 5 cm along y, the origin moves with w x (0, -0.05, 0) = (0.15, 0, 0)
    torch.testing.assert_close(ball.data.root_link_vel_w[0, :3], torch.tensor([0.15, 0.0, 0.0]), atol=1e-5, rtol=0)
    assert ball.data.root_link_vel_w[1:, :3].abs().max() < 1e-5
    com_pose = ball.data.root_com_pose_w.clone()
    com_pose[:, 0] += 0.2
    ball.write_root_com_pose_to_sim(com_pose)
    before[:, 0] += 0.2
    torch.testing.assert_close(ball.data.root_link_pose_w, before, atol=1e-5, rtol=0)
    # spinning freely by 0.6 rad, the centre of mass stays; about the origin it would go 3 cm
    for _ in range(10):
        env.sim.physics.step(4)
        env.scene.update(0.02)
    torch.testing.assert_close(ball.data.root_com_pos_w, com_pose[:, :3], atol=1e-3, rtol=0)
    assert (ball.data.root_link_pos_w[0] - before[0, :3]).norm() > 0.02


def test_collider_margins_are_set_in_the_chosen_environments(env):
    margins = env.sim.physics.randomizable("geom_margin")
    geom = env.scene["ball"]._geom_ids[0]
    mdp.randomize_rigid_body_collider_offsets(env, torch.tensor([1, 3]), BALL, (0.001, 0.002), (0.01, 0.02))
    assert ((margins[[1, 3], geom] >= 0.001) & (margins[[1, 3], geom] <= 0.002)).all()
    assert margins[[0, 2], geom].abs().max() == 0.0
    assert any("contact_offset_distribution_params" in path for path in ignored.pending_ignored())


def test_gravity_is_the_same_everywhere(env):
    mdp.randomize_physics_scene_gravity(env, None, ([0.0, 0.0, 1.0], [0.0, 0.0, 2.0]), "add")
    gravity = env.sim.physics.randomizable("opt.gravity")
    assert (gravity == gravity[0]).all()
    assert -8.81 - 1e-4 <= float(gravity[0, 2]) <= -7.81 + 1e-4
