"""Actuators, forces, masses and friction move assets as the laws of motion say, on both engines."""

import math

import numpy as np
import pytest
import torch
from arm_and_box import NUM_ENVS, SPACING, SceneCfg, arm_cfg, box_cfg, implicit, start
from pxr import Gf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.actuators import DCMotorCfg, IdealPDActuatorCfg, ImplicitActuatorCfg
from lift_lab.scene import InteractiveScene
from lift_lab.utils import configclass


@pytest.fixture(params=["native", pytest.param("warp", marks=pytest.mark.slow)])
def physics(request) -> str:
    return request.param


def test_a_free_body_falls_and_spins_as_the_closed_form_says(physics):
    sim, scene = start(physics, box=box_cfg())
    box = scene["box"]
    spin = torch.tensor([[0.1, 0.0, 0.0, 2.0, 0.0, 0.0]]).repeat(NUM_ENVS, 1)
    box.write_root_velocity_to_sim(spin)
    sim.physics.step(50)
    scene.update(0.1)
    t, dt = 0.1, 0.002
    # semi-implicit Euler: z = z0 - g t (t + dt) / 2
    expected_z = 2.0 - 9.81 * t * (t + dt) / 2
    torch.testing.assert_close(box.data.root_pos_w[:, 2], torch.full((NUM_ENVS,), expected_z), atol=1e-4, rtol=0)
    quat = torch.tensor([math.cos(0.1), math.sin(0.1), 0.0, 0.0]).repeat(NUM_ENVS, 1)
    torch.testing.assert_close(box.data.root_quat_w, quat, atol=1e-4, rtol=0)
    torch.testing.assert_close(box.data.root_ang_vel_w[:, 0], torch.full((NUM_ENVS,), 2.0), atol=1e-3, rtol=0)


def test_an_implicit_actuator_holds_its_target_without_gravity(physics, arm_file):
    sim, scene = start(physics, gravity=(0.0, 0.0, 0.0), arm=arm_cfg(arm_file, implicit(80.0, 8.0)))
    arm = scene["arm"]
    arm.set_joint_position_target(torch.tensor([[0.6, 0.1]]).repeat(NUM_ENVS, 1))
    for _ in range(20):
        scene.write_data_to_sim()
        sim.physics.step(100)
    scene.update(0.0)
    torch.testing.assert_close(arm.data.joint_pos, arm.data.joint_pos_target, atol=2e-3, rtol=0)


def test_the_engine_applies_the_pd_law(arm_file):
    sim, scene = start(arm=arm_cfg(arm_file, implicit(50.0, 5.0)))
    arm = scene["arm"]
    pos, vel = torch.tensor([[0.1, 0.2]]).repeat(NUM_ENVS, 1), torch.tensor([[1.0, -2.0]]).repeat(NUM_ENVS, 1)
    arm.write_joint_state_to_sim(pos, vel)
    arm.set_joint_position_target(torch.tensor([[0.3, 0.0]]).repeat(NUM_ENVS, 1))
    arm.set_joint_velocity_target(torch.tensor([[0.5, 0.5]]).repeat(NUM_ENVS, 1))
    arm.set_joint_effort_target(torch.tensor([[0.7, -0.4]]).repeat(NUM_ENVS, 1))
    scene.write_data_to_sim()
    sim.physics.forward()
    expected = 50.0 * torch.tensor([0.2, -0.2]) + 5.0 * torch.tensor([-0.5, 2.5]) + torch.tensor([0.7, -0.4])
    expected = expected.repeat(NUM_ENVS, 1)
    torch.testing.assert_close(sim.physics.field("qfrc_actuator")[:, :2], expected, atol=1e-4, rtol=0)
    torch.testing.assert_close(arm.data.applied_torque, expected, atol=1e-4, rtol=0)


def test_gains_left_none_come_from_the_usd_drive(arm_file):
    actuators = {"all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=None, damping=None)}
    _, scene = start(arm=arm_cfg(arm_file, actuators))
    data = scene["arm"].data
    torch.testing.assert_close(data.joint_stiffness, torch.full((NUM_ENVS, 2), 30.0), rtol=1e-5, atol=0)
    torch.testing.assert_close(data.joint_damping, torch.full((NUM_ENVS, 2), 3.0), rtol=1e-5, atol=0)
    torch.testing.assert_close(data.joint_effort_limits, torch.full((NUM_ENVS, 2), 25.0), rtol=1e-5, atol=0)


def test_an_ideal_pd_actuator_clips_at_its_effort_limit(arm_file):
    actuators = {"all": IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=100.0, damping=0.0, effort_limit=4.0)}
    sim, scene = start(arm=arm_cfg(arm_file, actuators))
    assert scene.substep_entities == ["arm"]
    scene["arm"].set_joint_position_target(torch.tensor([[0.32, 5.0]]).repeat(NUM_ENVS, 1))
    scene.write_data_to_sim()
    sim.physics.forward()
    expected = torch.tensor([[2.0, 4.0]]).repeat(NUM_ENVS, 1)
    torch.testing.assert_close(sim.physics.field("qfrc_actuator")[:, :2], expected, atol=1e-4, rtol=0)


def test_a_dc_motor_loses_effort_with_speed(arm_file):
    actuators = {
        "all": DCMotorCfg(
            joint_names_expr=[".*"],
            stiffness=1000.0,
            damping=0.0,
            effort_limit=8.0,
            saturation_effort=10.0,
            velocity_limit=4.0,
        )
    }
    _, scene = start(arm=arm_cfg(arm_file, actuators))
    arm = scene["arm"]
    arm.write_joint_velocity_to_sim(torch.tensor([[2.0, 0.0]]).repeat(NUM_ENVS, 1))
    arm.set_joint_position_target(torch.tensor([[2.0, 2.0]]).repeat(NUM_ENVS, 1))
    scene.write_data_to_sim()
    # at half the no-load speed half of the stall effort is left; standing still the limit holds
    torch.testing.assert_close(arm.data.applied_torque[0], torch.tensor([5.0, 8.0]))


def test_a_joint_without_stiffness_is_not_pushed_towards_its_target(arm_file):
    """Whether it began without or lost it: the PD law asks for no effort at rest."""
    gains = {"shoulder": 50.0, "elbow": 0.0}
    sim, scene = start(gravity=(0.0, 0.0, 0.0), arm=arm_cfg(arm_file, implicit(stiffness=gains, damping=0.5)))
    arm = scene["arm"]
    arm.write_joint_stiffness_to_sim(0.0, joint_ids=[0], env_ids=[1])
    arm.set_joint_position_target(torch.tensor([[0.3, 0.9]]).repeat(NUM_ENVS, 1))
    scene.write_data_to_sim()
    sim.step()
    torch.testing.assert_close(sim.physics.field("qfrc_actuator"), torch.zeros(NUM_ENVS, 2), atol=1e-6, rtol=0)


def test_the_acceleration_of_a_stiffly_damped_joint_is_that_of_its_velocity(physics, arm_file):
    """A damper of 50 N m s/rad stops the joint within two steps; the force at the start would reverse it."""
    sim, scene = start(physics, gravity=(0.0, 0.0, 0.0), arm=arm_cfg(arm_file, implicit(stiffness=0.0, damping=50.0)))
    arm = scene["arm"]
    assert not arm.data.joint_acc.any()
    arm.write_joint_velocity_to_sim(torch.tensor([[1.0, 0.0]]).repeat(NUM_ENVS, 1))
    before = arm.data.joint_vel.clone()
    scene.write_data_to_sim()
    sim.step()
    scene.update(sim.cfg.dt)
    change = (arm.data.joint_vel - before) / sim.cfg.dt
    torch.testing.assert_close(arm.data.joint_acc, change, rtol=1e-4, atol=1e-2)
    assert arm.data.joint_acc[0, 0] > -1.0 / sim.cfg.dt
    arm.write_joint_velocity_to_sim(torch.zeros(1, 2), env_ids=[0])
    assert not arm.data.joint_acc[0].any()


@pytest.mark.parametrize("is_global", [False, True])
def test_a_force_beside_the_centre_of_mass_turns_the_body(is_global):
    """1 N along y at 0.1 m along x: a torque of 0.1 N m about z, on a box of known inertia."""
    sim, scene = start(gravity=(0.0, 0.0, 0.0), box=box_cfg())
    box = scene["box"]
    force = torch.tensor([[[0.0, 1.0, 0.0]]]).repeat(NUM_ENVS, 1, 1)
    place = torch.tensor([[[0.1, 0.0, 0.0]]]).repeat(NUM_ENVS, 1, 1)
    if is_global:
        place = place + box.data.root_pos_w[:, None]
    before = box.data.root_vel_w.clone()
    box.set_external_force_and_torque(force, torch.zeros_like(force), place, None, None, is_global)
    scene.write_data_to_sim()
    sim.step()
    scene.update(sim.cfg.dt)
    inertia = 0.6 / 12 * (0.2**2 + 0.1**2)
    change = (box.data.root_vel_w - before) / sim.cfg.dt
    expected = torch.tensor([0.0, 1 / 0.6, 0.0, 0.0, 0.0, 0.1 / inertia]).repeat(NUM_ENVS, 1)
    torch.testing.assert_close(change, expected, rtol=1e-3, atol=1e-3)
    box.set_external_force_and_torque(torch.zeros(0, 3), torch.zeros(0, 3))
    scene.write_data_to_sim()
    assert not sim.physics.field("xfrc_applied").any()


def test_masses_of_one_environment_change_its_dynamics_alone(physics):
    sim, scene = start(physics, gravity=(0.0, 0.0, 0.0), box=box_cfg())
    box = scene["box"]
    box.write_root_velocity_to_sim(torch.zeros(NUM_ENVS, 6))
    box.write_body_mass_to_sim(torch.tensor([[1.2]]), env_ids=torch.tensor([1]))
    force = torch.tensor([[[3.0, 0.0, 0.0]]]).repeat(NUM_ENVS, 1, 1)
    box.set_external_force_and_torque(force, torch.zeros_like(force))
    scene.write_data_to_sim()
    sim.physics.step(10)
    scene.update(0.0)
    expected = 3.0 * 0.02 / torch.tensor([0.6, 1.2, 0.6])
    torch.testing.assert_close(box.data.root_lin_vel_w[:, 0], expected, rtol=1e-4, atol=0)


def test_a_mass_override_scales_the_inertia():
    sim, _ = start(box=box_cfg())
    body = sim.model.body("box/Box")
    assert body.mass[0] == pytest.approx(0.6)
    expected = 0.6 / 12 * np.array([0.1**2 + 0.1**2, 0.2**2 + 0.1**2, 0.2**2 + 0.1**2])
    np.testing.assert_allclose(np.sort(body.inertia), np.sort(expected), rtol=1e-5)


def test_a_mass_override_leaves_the_inertia_of_a_massless_link_alone(physics, arm_file, tmp_path):
    stage = Usd.Stage.Open(str(arm_file))
    tool = UsdGeom.Xform.Define(stage, "/Arm/tool")
    tool.AddTranslateOp().Set(Gf.Vec3d(0.8, 0, 0.5))
    UsdPhysics.RigidBodyAPI.Apply(tool.GetPrim())
    joint = UsdPhysics.FixedJoint.Define(stage, "/Arm/tool_joint")
    joint.CreateBody0Rel().SetTargets(["/Arm/lower"])
    joint.CreateBody1Rel().SetTargets(["/Arm/tool"])
    joint.CreateLocalPos0Attr(Gf.Vec3f(0.4, 0, 0))
    stage.Export(str(tmp_path / "arm.usda"))
    sim, scene = start(physics, arm=arm_cfg(tmp_path / "arm.usda", implicit()))
    arm = scene["arm"]
    masses = arm.data.default_mass[:1]
    assert (masses == 0).sum() == 1
    arm.write_body_mass_to_sim((2.0 * masses).clamp(min=1e-6), env_ids=[1])
    inertia = sim.physics.randomizable("body_inertia")[:, arm._ids]
    torch.testing.assert_close(inertia[1], 2.0 * inertia[0] * (masses[0] > 0)[:, None])
    scene.write_data_to_sim()
    sim.step()
    assert not sim.physics.health().failed.any()


def test_friction_of_one_environment_decides_whether_the_box_slides():
    cfg = box_cfg()
    cfg.init_state.pos = (0.0, 0.0, 0.05)
    cfg.init_state.lin_vel = (1.0, 0.0, 0.0)

    @configclass
    class _Ground(SceneCfg):
        ground = sim_utils_ground()

    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", dt=0.002))
    scene = InteractiveScene(_Ground(num_envs=2, env_spacing=SPACING, box=cfg))
    sim.reset()
    box = scene["box"]
    box.write_friction_to_sim(torch.tensor([0.9, 0.9]))
    box.write_friction_to_sim(torch.tensor([0.2]), env_ids=torch.tensor([1]))
    sim.physics.step(50)
    scene.update(0.0)
    # MuJoCo takes the larger of box and plane (0.1): deceleration mu g for 0.1 s
    expected = 1.0 - torch.tensor([0.9, 0.2]) * 9.81 * 0.1
    torch.testing.assert_close(box.data.root_lin_vel_w[:, 0], expected, atol=0.03, rtol=0)


def sim_utils_ground():
    from lift_lab.assets import AssetBaseCfg

    material = sim_utils.RigidBodyMaterialCfg(static_friction=0.1, dynamic_friction=0.1)
    return AssetBaseCfg(prim_path="/World/ground", spawn=sim_utils.GroundPlaneCfg(physics_material=material))


def test_gravity_is_compensated_where_it_is_disabled():
    sim, scene = start(box=box_cfg(disable_gravity=True))
    sim.physics.step(50)
    scene.update(0.0)
    torch.testing.assert_close(scene["box"].data.root_pos_w[:, 2], torch.full((NUM_ENVS,), 2.0), atol=1e-6, rtol=0)
