"""Assets read and write the engine's state in Isaac Lab's conventions, on both engines."""

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest
import torch
from pxr import Gf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.actuators import DCMotorCfg, IdealPDActuatorCfg, ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sensors import FrameTransformerCfg, OffsetCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError, NotFoundError, PhysicsError

NUM_ENVS = 3
SPACING = 2.0


def _author_arm(path: Path) -> None:
    """Two links on hinges about y, fixed to the world: shoulder at 0.5 m, link 1 is 0.4 m long."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    root = UsdGeom.Xform.Define(stage, "/Arm").GetPrim()
    stage.SetDefaultPrim(root)
    UsdPhysics.ArticulationRootAPI.Apply(root)
    for name, pos, mass in (
        ("base", (0, 0, 0.5), 2.0),
        ("upper", (0, 0, 0.5), 1.0),
        ("lower", (0.4, 0, 0.5), 0.5),
    ):
        link = UsdGeom.Xform.Define(stage, f"/Arm/{name}")
        link.AddTranslateOp().Set(Gf.Vec3d(*pos))
        UsdPhysics.RigidBodyAPI.Apply(link.GetPrim())
        api = UsdPhysics.MassAPI.Apply(link.GetPrim())
        api.CreateMassAttr(mass)
        api.CreateCenterOfMassAttr(Gf.Vec3f(0.2, 0, 0) if name != "base" else Gf.Vec3f(0, 0, 0))
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(0.01, 0.02, 0.02))
        api.CreatePrincipalAxesAttr(Gf.Quatf(1, 0, 0, 0))
    fixed = UsdPhysics.FixedJoint.Define(stage, "/Arm/root_joint")
    fixed.CreateBody1Rel().SetTargets(["/Arm/base"])
    fixed.CreateLocalPos0Attr(Gf.Vec3f(0, 0, 0.5))
    for name, body0, body1, at in (
        ("shoulder", "base", "upper", (0, 0, 0)),
        ("elbow", "upper", "lower", (0.4, 0, 0)),
    ):
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/Arm/{name}")
        joint.CreateBody0Rel().SetTargets([f"/Arm/{body0}"])
        joint.CreateBody1Rel().SetTargets([f"/Arm/{body1}"])
        joint.CreateLocalPos0Attr(Gf.Vec3f(*at))
        joint.CreateAxisAttr("Y")
        joint.CreateLowerLimitAttr(-90.0)
        joint.CreateUpperLimitAttr(120.0)
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
        drive.CreateStiffnessAttr(30.0 * math.pi / 180.0)
        drive.CreateDampingAttr(3.0 * math.pi / 180.0)
        drive.CreateMaxForceAttr(25.0)
    stage.Save()


@configclass
class _SceneCfg(InteractiveSceneCfg):
    arm: ArticulationCfg | None = None
    box: RigidObjectCfg | None = None
    tip: FrameTransformerCfg | None = None


def _box(**rigid) -> RigidObjectCfg:
    return RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Box",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(1.0, 0.0, 2.0), lin_vel=(0.5, 0.0, 0.0)),
        spawn=sim_utils.CuboidCfg(
            size=(0.2, 0.1, 0.1),
            rigid_props=sim_utils.RigidBodyPropertiesCfg(**rigid),
            mass_props=sim_utils.MassPropertiesCfg(mass=0.6),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )


def _arm(path: Path, actuators: dict) -> ArticulationCfg:
    return ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Arm",
        spawn=sim_utils.UsdFileCfg(usd_path=str(path)),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={"shoulder": 0.3, "elbow": -0.2}),
        actuators=actuators,
    )


def _implicit(stiffness=50.0, damping=5.0) -> dict:
    return {"all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=stiffness, damping=damping)}


@pytest.fixture(scope="module")
def arm_file(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("usd") / "arm.usda"
    _author_arm(path)
    return path


@pytest.fixture(scope="module")
def one_arm(arm_file):
    """An arm that no test changes."""
    sim, scene = _start(arm=_arm(arm_file, _implicit()))
    yield scene["arm"]
    sim.close()


def _start(physics: str = "native", gravity=(0.0, 0.0, -9.81), num_envs: int = NUM_ENVS, **entities):
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=physics, dt=0.002, gravity=gravity))
    scene = InteractiveScene(_SceneCfg(num_envs=num_envs, env_spacing=SPACING, **entities))
    sim.reset()
    scene.update(0.0)
    return sim, scene


@pytest.fixture(params=["native", pytest.param("warp", marks=pytest.mark.slow)])
def physics(request) -> str:
    return request.param


def test_the_default_state_is_where_the_config_puts_it(physics, arm_file):
    _, scene = _start(physics, arm=_arm(arm_file, _implicit()), box=_box())
    arm, box = scene["arm"], scene["box"]
    assert arm.joint_names == ["shoulder", "elbow"]
    assert arm.body_names == ["base", "upper", "lower"]
    assert box.body_names == ["Box"]
    torch.testing.assert_close(arm.data.joint_pos, torch.tensor([[0.3, -0.2]]).repeat(NUM_ENVS, 1))
    expected = scene.env_origins + torch.tensor([1.0, 0.0, 2.0])
    torch.testing.assert_close(box.data.root_pos_w, expected)
    torch.testing.assert_close(box.data.root_lin_vel_w, torch.tensor([[0.5, 0.0, 0.0]]).repeat(NUM_ENVS, 1))


def test_body_positions_are_forward_kinematics_plus_the_origin(physics, arm_file):
    _, scene = _start(physics, arm=_arm(arm_file, _implicit()))
    q1 = 0.3
    elbow = torch.tensor([0.4 * math.cos(q1), 0.0, 0.5 - 0.4 * math.sin(q1)])
    torch.testing.assert_close(scene["arm"].data.body_pos_w[:, 2], scene.env_origins + elbow, atol=1e-5, rtol=0)


def test_a_root_pose_written_in_the_world_is_read_back(physics):
    _, scene = _start(physics, box=_box())
    box = scene["box"]
    pose = torch.tensor([[3.0, -1.0, 4.0, 0.5, 0.5, 0.5, 0.5]]) + torch.zeros(2, 7)
    box.write_root_pose_to_sim(pose, torch.tensor([0, 2]))
    torch.testing.assert_close(box.data.root_pose_w[[0, 2]], pose)
    torch.testing.assert_close(box.data.root_pos_w[1], scene.env_origins[1] + torch.tensor([1.0, 0.0, 2.0]))


def test_a_free_body_falls_and_spins_as_the_closed_form_says(physics):
    sim, scene = _start(physics, box=_box())
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
    sim, scene = _start(physics, gravity=(0.0, 0.0, 0.0), arm=_arm(arm_file, _implicit(80.0, 8.0)))
    arm = scene["arm"]
    arm.set_joint_position_target(torch.tensor([[0.6, 0.1]]).repeat(NUM_ENVS, 1))
    for _ in range(20):
        scene.write_data_to_sim()
        sim.physics.step(100)
    scene.update(0.0)
    torch.testing.assert_close(arm.data.joint_pos, arm.data.joint_pos_target, atol=2e-3, rtol=0)


def test_the_engine_applies_the_pd_law(arm_file):
    sim, scene = _start(arm=_arm(arm_file, _implicit(50.0, 5.0)))
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
    _, scene = _start(arm=_arm(arm_file, actuators))
    data = scene["arm"].data
    torch.testing.assert_close(data.joint_stiffness, torch.full((NUM_ENVS, 2), 30.0), rtol=1e-5, atol=0)
    torch.testing.assert_close(data.joint_damping, torch.full((NUM_ENVS, 2), 3.0), rtol=1e-5, atol=0)
    torch.testing.assert_close(data.joint_effort_limits, torch.full((NUM_ENVS, 2), 25.0), rtol=1e-5, atol=0)


def test_an_ideal_pd_actuator_clips_at_its_effort_limit(arm_file):
    actuators = {"all": IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=100.0, damping=0.0, effort_limit=4.0)}
    sim, scene = _start(arm=_arm(arm_file, actuators))
    assert scene.requires_substep_writes
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
    _, scene = _start(arm=_arm(arm_file, actuators))
    arm = scene["arm"]
    arm.write_joint_velocity_to_sim(torch.tensor([[2.0, 0.0]]).repeat(NUM_ENVS, 1))
    arm.set_joint_position_target(torch.tensor([[2.0, 2.0]]).repeat(NUM_ENVS, 1))
    scene.write_data_to_sim()
    # at half the no-load speed half of the stall effort is left; standing still the limit holds
    torch.testing.assert_close(arm.data.applied_torque[0], torch.tensor([5.0, 8.0]))


def test_masses_of_one_environment_change_its_dynamics_alone(physics):
    sim, scene = _start(physics, gravity=(0.0, 0.0, 0.0), box=_box())
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


def test_friction_of_one_environment_decides_whether_the_box_slides():
    cfg = _box()
    cfg.init_state.pos = (0.0, 0.0, 0.05)
    cfg.init_state.lin_vel = (1.0, 0.0, 0.0)

    @configclass
    class _Ground(_SceneCfg):
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


def test_a_frame_transformer_adds_its_offset_in_the_body_frame(physics, arm_file):
    tip = FrameTransformerCfg(
        prim_path="{ENV_REGEX_NS}/Arm/base",
        target_frames=[
            FrameTransformerCfg.FrameCfg(
                prim_path="{ENV_REGEX_NS}/Arm/upper", name="tip", offset=OffsetCfg(pos=(0.5, 0.0, 0.0))
            )
        ],
    )
    _, scene = _start(physics, arm=_arm(arm_file, _implicit()), tip=tip)
    data = scene["tip"].data
    reach = torch.tensor([0.5 * math.cos(0.3), 0.0, -0.5 * math.sin(0.3)])
    shoulder = torch.tensor([0.0, 0.0, 0.5])
    torch.testing.assert_close(data.target_pos_w[:, 0], scene.env_origins + shoulder + reach, atol=1e-5, rtol=0)
    torch.testing.assert_close(data.target_pos_source[:, 0], reach.repeat(NUM_ENVS, 1), atol=1e-5, rtol=0)
    quat = torch.tensor([math.cos(0.15), 0.0, math.sin(0.15), 0.0]).repeat(NUM_ENVS, 1)
    torch.testing.assert_close(data.target_quat_source[:, 0], quat, atol=1e-5, rtol=0)
    assert data.target_frame_names == ["tip"]


def test_body_velocities_are_those_of_mujocos_object_velocity(arm_file):
    sim, scene = _start(arm=_arm(arm_file, _implicit()))
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
    sim, scene = _start(arm=_arm(arm_file, _implicit()))
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
    sim, scene = _start(arm=_arm(arm_file, _implicit()))
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


def test_gravity_is_compensated_where_it_is_disabled():
    sim, scene = _start(box=_box(disable_gravity=True))
    sim.physics.step(50)
    scene.update(0.0)
    torch.testing.assert_close(scene["box"].data.root_pos_w[:, 2], torch.full((NUM_ENVS,), 2.0), atol=1e-6, rtol=0)


def test_a_kinematic_object_stays_where_it_is_put():
    sim, scene = _start(box=_box(kinematic_enabled=True))
    box = scene["box"]
    pose = torch.cat((scene.env_origins + 1.0, torch.tensor([[1.0, 0, 0, 0]]).repeat(NUM_ENVS, 1)), dim=1)
    box.write_root_pose_to_sim(pose)
    sim.physics.step(20)
    scene.update(0.0)
    torch.testing.assert_close(box.data.body_pos_w[:, 0], scene.env_origins + 1.0)


def test_a_mass_override_scales_the_inertia():
    sim, _ = _start(box=_box())
    body = sim.model.body("box/Box")
    assert body.mass[0] == pytest.approx(0.6)
    expected = 0.6 / 12 * np.array([0.1**2 + 0.1**2, 0.2**2 + 0.1**2, 0.2**2 + 0.1**2])
    np.testing.assert_allclose(np.sort(body.inertia), np.sort(expected), rtol=1e-5)


def test_a_state_taken_can_be_put_back(arm_file):
    sim, scene = _start(arm=_arm(arm_file, _implicit()), box=_box())
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
    cfg = _arm(arm_file, _implicit())
    cfg.init_state.joint_pos = change
    with pytest.raises(ConfigError, match=message):
        _start(arm=cfg)


def test_an_actuator_pattern_without_a_joint_is_named(arm_file):
    cfg = _arm(arm_file, {"hand": ImplicitActuatorCfg(joint_names_expr=["wrist"], stiffness=1.0, damping=1.0)})
    with pytest.raises(ConfigError, match=r"actuators\['hand'\].joint_names_expr.*wrist"):
        _start(arm=cfg)


def test_an_unknown_entity_is_answered_with_the_nearest(arm_file):
    _, scene = _start(arm=_arm(arm_file, _implicit()))
    with pytest.raises(NotFoundError, match=r"'arn'.*'arm'"):
        scene["arn"]


def test_a_target_frame_on_an_unknown_body_is_named(arm_file):
    tip = FrameTransformerCfg(
        prim_path="{ENV_REGEX_NS}/Arm/base",
        target_frames=[FrameTransformerCfg.FrameCfg(prim_path="{ENV_REGEX_NS}/Arm/uper")],
    )
    with pytest.raises(ConfigError, match=r"scene.tip.target_frames\[0\].prim_path.*'uper'.*'upper'"):
        _start(arm=_arm(arm_file, _implicit()), tip=tip)


def test_physx_settings_are_noted_as_ignored():
    from lift_lab.sim.ignored import pending_ignored

    _start(box=_box(solver_position_iteration_count=16, max_depenetration_velocity=5.0))
    noted = pending_ignored()
    assert "scene.box.spawn.rigid_props.solver_position_iteration_count" in noted
    assert "scene.box.spawn.rigid_props.max_depenetration_velocity" in noted


def test_a_joint_without_stiffness_is_not_pushed_towards_its_target(arm_file):
    """Whether it began without or lost it: the PD law asks for no effort at rest."""
    gains = {"shoulder": 50.0, "elbow": 0.0}
    sim, scene = _start(gravity=(0.0, 0.0, 0.0), arm=_arm(arm_file, _implicit(stiffness=gains, damping=0.5)))
    arm = scene["arm"]
    arm.write_joint_stiffness_to_sim(0.0, joint_ids=[0], env_ids=[1])
    arm.set_joint_position_target(torch.tensor([[0.3, 0.9]]).repeat(NUM_ENVS, 1))
    scene.write_data_to_sim()
    sim.step()
    torch.testing.assert_close(sim.physics.field("qfrc_actuator"), torch.zeros(NUM_ENVS, 2), atol=1e-6, rtol=0)


def test_soft_limits_follow_the_limits(arm_file):
    cfg = _arm(arm_file, _implicit())
    cfg.soft_joint_pos_limit_factor = 0.5
    _, scene = _start(arm=cfg)
    arm = scene["arm"]
    arm.write_joint_position_limit_to_sim(torch.tensor([[[-0.4, 0.8]]]), joint_ids=[0], env_ids=[1])
    torch.testing.assert_close(arm.data.soft_joint_pos_limits[1, 0], torch.tensor([-0.1, 0.5]))
    middle, half = math.radians(15.0), math.radians(52.5)
    torch.testing.assert_close(arm.data.soft_joint_pos_limits[0, 0], torch.tensor([middle - half, middle + half]))


@pytest.mark.parametrize("env_ids", [torch.tensor([False, False, True]), [False, False, True], torch.tensor([2.0])])
def test_a_mask_or_fractions_are_no_environments(arm_file, env_ids):
    _, scene = _start(arm=_arm(arm_file, _implicit()))
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
    sim, scene = _start(physics, arm=_arm(tmp_path / "arm.usda", _implicit()))
    arm = scene["arm"]
    masses = arm.data.default_mass[:1]
    assert (masses == 0).sum() == 1
    arm.write_body_mass_to_sim((2.0 * masses).clamp(min=1e-6), env_ids=[1])
    inertia = sim.physics.randomizable("body_inertia")[:, arm._ids]
    torch.testing.assert_close(inertia[1], 2.0 * inertia[0] * (masses[0] > 0)[:, None])
    scene.write_data_to_sim()
    sim.step()
    assert not sim.physics.health().failed.any()


def test_a_rigid_object_without_rigid_props_is_refused():
    box = _box()
    box.spawn.rigid_props = None
    with pytest.raises(ConfigError, match=r"scene.box: .* set rigid_props .* AssetBaseCfg"):
        _start(box=box)


def test_a_root_that_is_put_elsewhere_keeps_its_velocity_in_the_world(physics):
    """Turned by 90 degrees about z: neither the spin about x nor the velocity of the centre of mass turns with it."""
    _, scene = _start(physics, gravity=(0.0, 0.0, 0.0), box=_box())
    box = scene["box"]
    box.data._com_b[:, 0] = torch.tensor([0.03, 0.0, 0.0])  # as of a body whose centre of mass is off its origin
    box.data._root_com_is_origin = False
    velocity = torch.tensor([[0.1, 0.2, 0.3, 1.0, 0.0, 0.0]]).repeat(NUM_ENVS, 1)
    box.write_root_velocity_to_sim(velocity)
    half = math.sqrt(0.5)
    pose = torch.tensor([[0.0, 0.0, 3.0, half, 0.0, 0.0, half]]) + torch.nn.functional.pad(scene.env_origins, (0, 4))
    box.write_root_pose_to_sim(pose[1:2], env_ids=[1])
    torch.testing.assert_close(box.data.root_com_vel_w, velocity, atol=1e-6, rtol=0)
    torch.testing.assert_close(box.data.root_link_pose_w[1], pose[1])
    torch.testing.assert_close(box.data.body_link_pose_w[1, 0], pose[1], atol=1e-6, rtol=0)


def test_a_fixed_root_can_be_neither_moved_nor_turned(arm_file):
    _, scene = _start(arm=_arm(arm_file, _implicit()))
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
    _, scene = _start(box=_box(kinematic_enabled=True))
    box, state = scene["box"], scene.get_state(is_relative=True)
    pose = box.data.root_pose_w.clone()
    moved = pose.clone()
    moved[:, 2] += 1.0
    box.write_root_pose_to_sim(moved)
    scene.reset_to(state, is_relative=True)
    torch.testing.assert_close(box.data.root_pose_w, pose)


def test_bodies_are_where_written_joints_put_them(physics, arm_file):
    """Before any step: shoulder at 90 degrees about y, so that the elbow is 0.4 m below it."""
    _, scene = _start(physics, arm=_arm(arm_file, _implicit()))
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


def test_the_acceleration_of_a_stiffly_damped_joint_is_that_of_its_velocity(physics, arm_file):
    """A damper of 50 N m s/rad stops the joint within two steps; the force at the start would reverse it."""
    sim, scene = _start(physics, gravity=(0.0, 0.0, 0.0), arm=_arm(arm_file, _implicit(stiffness=0.0, damping=50.0)))
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
    sim, scene = _start(gravity=(0.0, 0.0, 0.0), box=_box())
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
