"""Assets read and write the engine's state in Isaac Lab's conventions, on both engines."""

import math

import mujoco
import numpy as np
import pytest
import torch
from arm_and_box import NUM_ENVS, arm_cfg, box_cfg, implicit, start

from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.sensors import FrameTransformerCfg, OffsetCfg
from lift_lab.utils.errors import ConfigError, NotFoundError, PhysicsError


@pytest.fixture(scope="module")
def one_arm(arm_file):
    """An arm that no test changes."""
    sim, scene = start(arm=arm_cfg(arm_file, implicit()))
    yield scene["arm"]
    sim.close()


@pytest.fixture(params=["native", pytest.param("warp", marks=pytest.mark.slow)])
def physics(request) -> str:
    return request.param


def test_the_default_state_is_where_the_config_puts_it(physics, arm_file):
    _, scene = start(physics, arm=arm_cfg(arm_file, implicit()), box=box_cfg())
    arm, box = scene["arm"], scene["box"]
    assert arm.joint_names == ["shoulder", "elbow"]
    assert arm.body_names == ["base", "upper", "lower"]
    assert box.body_names == ["Box"]
    torch.testing.assert_close(arm.data.joint_pos, torch.tensor([[0.3, -0.2]]).repeat(NUM_ENVS, 1))
    expected = scene.env_origins + torch.tensor([1.0, 0.0, 2.0])
    torch.testing.assert_close(box.data.root_pos_w, expected)
    torch.testing.assert_close(box.data.root_lin_vel_w, torch.tensor([[0.5, 0.0, 0.0]]).repeat(NUM_ENVS, 1))


def test_body_positions_are_forward_kinematics_plus_the_origin(physics, arm_file):
    _, scene = start(physics, arm=arm_cfg(arm_file, implicit()))
    q1 = 0.3
    elbow = torch.tensor([0.4 * math.cos(q1), 0.0, 0.5 - 0.4 * math.sin(q1)])
    torch.testing.assert_close(scene["arm"].data.body_pos_w[:, 2], scene.env_origins + elbow, atol=1e-5, rtol=0)


def test_a_root_pose_written_in_the_world_is_read_back(physics):
    _, scene = start(physics, box=box_cfg())
    box = scene["box"]
    pose = torch.tensor([[3.0, -1.0, 4.0, 0.5, 0.5, 0.5, 0.5]]) + torch.zeros(2, 7)
    box.write_root_pose_to_sim(pose, torch.tensor([0, 2]))
    torch.testing.assert_close(box.data.root_pose_w[[0, 2]], pose)
    torch.testing.assert_close(box.data.root_pos_w[1], scene.env_origins[1] + torch.tensor([1.0, 0.0, 2.0]))


def test_a_frame_transformer_adds_its_offset_in_the_body_frame(physics, arm_file):
    tip = FrameTransformerCfg(
        prim_path="{ENV_REGEX_NS}/Arm/base",
        target_frames=[
            FrameTransformerCfg.FrameCfg(
                prim_path="{ENV_REGEX_NS}/Arm/upper", name="tip", offset=OffsetCfg(pos=(0.5, 0.0, 0.0))
            )
        ],
    )
    _, scene = start(physics, arm=arm_cfg(arm_file, implicit()), tip=tip)
    data = scene["tip"].data
    reach = torch.tensor([0.5 * math.cos(0.3), 0.0, -0.5 * math.sin(0.3)])
    shoulder = torch.tensor([0.0, 0.0, 0.5])
    torch.testing.assert_close(data.target_pos_w[:, 0], scene.env_origins + shoulder + reach, atol=1e-5, rtol=0)
    torch.testing.assert_close(data.target_pos_source[:, 0], reach.repeat(NUM_ENVS, 1), atol=1e-5, rtol=0)
    quat = torch.tensor([math.cos(0.15), 0.0, math.sin(0.15), 0.0]).repeat(NUM_ENVS, 1)
    torch.testing.assert_close(data.target_quat_source[:, 0], quat, atol=1e-5, rtol=0)
    assert data.target_frame_names == ["tip"]


def test_body_velocities_are_those_of_mujocos_object_velocity(arm_file):
    sim, scene = start(arm=arm_cfg(arm_file, implicit()))
    arm = scene["arm"]
    arm.write_joint_velocity_to_sim(torch.tensor([[0.7, -1.3]]).repeat(NUM_ENVS, 1))
    arm.data.body_vel_w  # noqa: B018  bind the velocity fields
    sim.physics.refresh()
    scene.update(0.0)
    data = sim.physics.get_data(0)
    mujoco.mj_forward(sim.model, data)
    for k, name in enumerate(arm.body_names):
        body = sim.model.body(f"arm/{name}").id
        velocity = np.zeros(6)
        mujoco.mj_objectVelocity(sim.model, data, mujoco.mjtObj.mjOBJ_BODY, body, velocity, 0)
        expected = torch.tensor(np.r_[velocity[3:], velocity[:3]], dtype=torch.float32)
        torch.testing.assert_close(arm.data.body_vel_w[0, k], expected, atol=1e-5, rtol=0)
        mujoco.mj_objectVelocity(sim.model, data, mujoco.mjtObj.mjOBJ_XBODY, body, velocity, 0)
        expected = torch.tensor(np.r_[velocity[3:], velocity[:3]], dtype=torch.float32)
        torch.testing.assert_close(arm.data.body_link_state_w[0, k, 7:], expected, atol=1e-5, rtol=0)


def test_body_accelerations_are_those_of_circular_motion(arm_file):
    sim, scene = start(arm=arm_cfg(arm_file, implicit()))
    arm = scene["arm"]
    omega = 1.7
    arm.write_joint_velocity_to_sim(torch.tensor([[omega, 0.0]]).repeat(NUM_ENVS, 1))
    arm.data.body_acc_w  # noqa: B018  bind the fields
    sim.physics.forward()
    scene.update(0.0)
    alpha = float(arm.data.joint_acc[0, 0])
    # the centre of mass of the upper link runs on a circle of 0.2 m about the shoulder, in the x-z plane
    q = 0.3
    radial = torch.tensor([math.cos(q), 0.0, -math.sin(q)])
    tangent = torch.tensor([-math.sin(q), 0.0, -math.cos(q)])
    expected = 0.2 * (alpha * tangent - omega**2 * radial)
    torch.testing.assert_close(arm.data.body_lin_acc_w[0, 1], expected, atol=1e-3, rtol=1e-4)
    torch.testing.assert_close(arm.data.body_ang_acc_w[0, 1], torch.tensor([0.0, alpha, 0.0]), atol=1e-3, rtol=1e-4)


def test_the_jacobian_is_the_derivative_of_the_body_position(arm_file):
    sim, scene = start(arm=arm_cfg(arm_file, implicit()))
    arm = scene["arm"]
    jacobian = arm.get_jacobians(2)[0]
    before = arm.data.body_pos_w[0, 2].double().clone()
    eps = 1e-3
    for j in range(2):
        step = arm.data.default_joint_pos.clone()
        step[:, j] += eps
        arm.write_joint_position_to_sim(step)
        sim.physics.refresh()
        scene.update(0.0)
        slope = (arm.data.body_pos_w[0, 2].double() - before) / eps
        torch.testing.assert_close(jacobian[:3, j].double(), slope, atol=2e-3, rtol=0)
    torch.testing.assert_close(jacobian[3:], torch.tensor([[0.0, 0.0], [1.0, 1.0], [0.0, 0.0]]), atol=1e-6, rtol=0)


def test_a_kinematic_object_stays_where_it_is_put():
    sim, scene = start(box=box_cfg(kinematic_enabled=True))
    box = scene["box"]
    pose = torch.cat((scene.env_origins + 1.0, torch.tensor([[1.0, 0, 0, 0]]).repeat(NUM_ENVS, 1)), dim=1)
    box.write_root_pose_to_sim(pose)
    sim.physics.step(20)
    scene.update(0.0)
    torch.testing.assert_close(box.data.body_pos_w[:, 0], scene.env_origins + 1.0)


def test_a_state_taken_can_be_put_back(arm_file):
    sim, scene = start(arm=arm_cfg(arm_file, implicit()), box=box_cfg())
    state = scene.get_state(is_relative=True)
    sim.physics.step(30)
    scene.update(0.0)
    assert not torch.allclose(scene["box"].data.root_pos_w[:, 2], torch.tensor(2.0))
    scene.reset_to(state, is_relative=True)
    sim.physics.refresh()
    scene.update(0.0)
    torch.testing.assert_close(scene.get_state(is_relative=True), state)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"shoulder": 9.0}, r"9.0000 of 'shoulder' is outside its limits \[-1.5708, 2.0944\]"),
        ({"sholder": 0.1}, "shoulder"),
    ],
)
def test_a_wrong_default_joint_position_is_named(arm_file, change, message):
    cfg = arm_cfg(arm_file, implicit())
    cfg.init_state.joint_pos = change
    with pytest.raises(ConfigError, match=message):
        start(arm=cfg)


def test_an_actuator_pattern_without_a_joint_is_named(arm_file):
    cfg = arm_cfg(arm_file, {"hand": ImplicitActuatorCfg(joint_names_expr=["wrist"], stiffness=1.0, damping=1.0)})
    with pytest.raises(ConfigError, match=r"actuators\['hand'\].joint_names_expr.*wrist"):
        start(arm=cfg)


def test_an_unknown_entity_is_answered_with_the_nearest(arm_file):
    _, scene = start(arm=arm_cfg(arm_file, implicit()))
    with pytest.raises(NotFoundError, match=r"'arn'.*'arm'"):
        scene["arn"]


def test_a_target_frame_on_an_unknown_body_is_named(arm_file):
    tip = FrameTransformerCfg(
        prim_path="{ENV_REGEX_NS}/Arm/base",
        target_frames=[FrameTransformerCfg.FrameCfg(prim_path="{ENV_REGEX_NS}/Arm/uper")],
    )
    with pytest.raises(ConfigError, match=r"scene.tip.target_frames\[0\].prim_path.*'uper'.*'upper'"):
        start(arm=arm_cfg(arm_file, implicit()), tip=tip)


def test_physx_settings_are_noted_as_ignored():
    from lift_lab.sim.ignored import pending_ignored

    start(box=box_cfg(solver_position_iteration_count=16, max_depenetration_velocity=5.0))
    noted = pending_ignored()
    assert "scene.box.spawn.rigid_props.solver_position_iteration_count" in noted
    assert "scene.box.spawn.rigid_props.max_depenetration_velocity" in noted


def test_soft_limits_follow_the_limits(arm_file):
    cfg = arm_cfg(arm_file, implicit())
    cfg.soft_joint_pos_limit_factor = 0.5
    _, scene = start(arm=cfg)
    arm = scene["arm"]
    arm.write_joint_position_limit_to_sim(torch.tensor([[[-0.4, 0.8]]]), joint_ids=[0], env_ids=[1])
    torch.testing.assert_close(arm.data.soft_joint_pos_limits[1, 0], torch.tensor([-0.1, 0.5]))
    middle, half = math.radians(15.0), math.radians(52.5)
    torch.testing.assert_close(arm.data.soft_joint_pos_limits[0, 0], torch.tensor([middle - half, middle + half]))


@pytest.mark.parametrize("env_ids", [torch.tensor([False, False, True]), [False, False, True], torch.tensor([2.0])])
def test_a_mask_or_fractions_are_no_environments(arm_file, env_ids):
    _, scene = start(arm=arm_cfg(arm_file, implicit()))
    with pytest.raises(ConfigError, match="ids must be integers"):
        scene["arm"].write_joint_position_to_sim(torch.zeros(1, 2), env_ids=env_ids)


@pytest.mark.parametrize("ids", [torch.tensor([True, False]), [True, False], torch.tensor([0.0])])
@pytest.mark.parametrize(
    "write",
    [
        lambda arm, ids: arm.write_joint_position_to_sim(torch.ones(NUM_ENVS, 1), joint_ids=ids),
        lambda arm, ids: arm.set_joint_position_target(torch.ones(NUM_ENVS, 1), joint_ids=ids),
        lambda arm, ids: arm.write_joint_position_limit_to_sim(torch.ones(NUM_ENVS, 1, 2), joint_ids=ids),
        lambda arm, ids: arm.write_body_mass_to_sim(torch.ones(NUM_ENVS, 1), body_ids=ids),
        lambda arm, ids: arm.write_friction_to_sim(torch.ones(NUM_ENVS), body_ids=ids),
        lambda arm, ids: arm.set_external_force_and_torque(*torch.ones(2, NUM_ENVS, 1, 3), body_ids=ids),
    ],
    ids=["joint state", "target", "limit", "mass", "friction", "wrench"],
)
def test_a_mask_or_fractions_are_no_joints_or_bodies(one_arm, write, ids):
    with pytest.raises(ConfigError, match="ids must be integers"):
        write(one_arm, ids)


def test_a_rigid_object_without_rigid_props_is_refused():
    box = box_cfg()
    box.spawn.rigid_props = None
    with pytest.raises(ConfigError, match=r"scene.box: .* set rigid_props .* AssetBaseCfg"):
        start(box=box)


def test_a_root_that_is_put_elsewhere_keeps_its_velocity_in_the_world(physics):
    """Turned by 90 degrees about z: neither the spin about x nor the velocity of the centre of mass turns with it."""
    _, scene = start(physics, gravity=(0.0, 0.0, 0.0), box=box_cfg())
    box = scene["box"]
    # as of a body whose centre of mass is off its origin
    box.data.set_body_com(torch.arange(NUM_ENVS), torch.tensor([0]), torch.tensor([0.03, 0.0, 0.0]))
    velocity = torch.tensor([[0.1, 0.2, 0.3, 1.0, 0.0, 0.0]]).repeat(NUM_ENVS, 1)
    box.write_root_velocity_to_sim(velocity)
    half = math.sqrt(0.5)
    pose = torch.tensor([[0.0, 0.0, 3.0, half, 0.0, 0.0, half]]) + torch.nn.functional.pad(scene.env_origins, (0, 4))
    box.write_root_pose_to_sim(pose[1:2], env_ids=[1])
    torch.testing.assert_close(box.data.root_com_vel_w, velocity, atol=1e-6, rtol=0)
    torch.testing.assert_close(box.data.root_link_pose_w[1], pose[1])
    torch.testing.assert_close(box.data.body_link_pose_w[1, 0], pose[1], atol=1e-6, rtol=0)


def test_a_fixed_root_can_be_neither_moved_nor_turned(arm_file):
    _, scene = start(arm=arm_cfg(arm_file, implicit()))
    arm = scene["arm"]
    at_home = arm.data.default_root_state.clone()
    at_home[:, :3] += scene.env_origins
    arm.write_root_state_to_sim(at_home)  # its root link is half a metre above the prim
    torch.testing.assert_close(arm.data.root_pos_w, at_home[:, :3])
    turned = at_home[:, :7].clone()
    turned[:, 3:] = torch.tensor([math.cos(0.1), 0.0, 0.0, math.sin(0.1)])
    with pytest.raises(PhysicsError, match="neither moved nor turned"):
        arm.write_root_pose_to_sim(turned)


def test_a_kinematic_object_is_put_back_with_the_state(arm_file):
    _, scene = start(box=box_cfg(kinematic_enabled=True))
    box, state = scene["box"], scene.get_state(is_relative=True)
    pose = box.data.root_pose_w.clone()
    moved = pose.clone()
    moved[:, 2] += 1.0
    box.write_root_pose_to_sim(moved)
    scene.reset_to(state, is_relative=True)
    torch.testing.assert_close(box.data.root_pose_w, pose)


def test_bodies_are_where_written_joints_put_them(physics, arm_file):
    """Before any step: shoulder at 90 degrees about y, so that the elbow is 0.4 m below it."""
    _, scene = start(physics, arm=arm_cfg(arm_file, implicit()))
    arm = scene["arm"]
    before = arm.data.body_pos_w.clone()
    arm.write_joint_position_to_sim(torch.tensor([[math.pi / 2, 0.0]]), env_ids=[1])
    expected = scene.env_origins[1] + torch.tensor([0.0, 0.0, 0.1])
    torch.testing.assert_close(arm.data.body_pos_w[1, 2], expected, atol=1e-5, rtol=0)
    torch.testing.assert_close(arm.data.body_pos_w[0], before[0])
    pos_w, quat_w = arm.data.link_pose_of(2)
    torch.testing.assert_close(pos_w[1], expected, atol=1e-5, rtol=0)
    half_angles = torch.tensor([0.05, math.pi / 4])  # 0.3 - 0.2 rad about y, and a quarter turn
    torch.testing.assert_close(
        quat_w[:2, ::2], torch.stack((half_angles.cos(), half_angles.sin()), 1), atol=1e-5, rtol=0
    )
    assert not quat_w[:2, 1::2].any()
