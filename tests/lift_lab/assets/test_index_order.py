"""Joints and bodies of a branching robot have Isaac Lab's numbers; each number is compared with MuJoCo's by name."""

import mujoco
import numpy as np
import pytest
import torch
from pxr import Gf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.actuators import IdealPDActuatorCfg, ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sensors import ContactSensorCfg, FrameTransformerCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError

NUM_ENVS = 3
JOINTS = ["right_hip", "left_hip", "right_knee", "left_knee"]
ENGINE_JOINTS = ["right_hip", "right_knee", "left_hip", "left_knee"]
BODIES = ["trunk", "right_thigh", "left_thigh", "right_shank", "left_shank", "right_foot", "left_foot"]
ENGINE_BODIES = ["trunk", "right_thigh", "right_shank", "right_foot", "left_thigh", "left_shank", "left_foot"]
STAGE_BODIES = ["left_foot", "left_shank", "left_thigh", "right_foot", "right_shank", "right_thigh", "trunk"]


@pytest.fixture(scope="module")
def walker_file(tmp_path_factory):
    """Two legs of hip, knee and a foot that is fixed to the shank. Bodies by name on the stage, joints right first."""
    path = tmp_path_factory.mktemp("usd") / "walker.usda"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    root = UsdGeom.Xform.Define(stage, "/walker")
    stage.SetDefaultPrim(root.GetPrim())
    places = {"trunk": (0, 0, 1.0)}
    for side, y in (("right", -0.2), ("left", 0.2)):
        places |= {f"{side}_thigh": (0, y, 0.7), f"{side}_shank": (0, y, 0.4), f"{side}_foot": (0.05, y, 0.2)}
    for i, name in enumerate(STAGE_BODIES):
        cube = UsdGeom.Cube.Define(stage, f"/walker/{name}")
        cube.CreateSizeAttr(0.1)
        cube.AddTranslateOp().Set(Gf.Vec3d(*places[name]))
        UsdPhysics.RigidBodyAPI.Apply(cube.GetPrim())
        UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
        mass = UsdPhysics.MassAPI.Apply(cube.GetPrim())
        mass.CreateMassAttr(1.0 + i)
        mass.CreateDiagonalInertiaAttr(Gf.Vec3f(0.01, 0.01, 0.01))
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath("/walker/trunk"))
    for side, y in (("right", -0.2), ("left", 0.2)):
        for name, kind, parent, child, at in (
            ("hip", "RevoluteJoint", "trunk", f"{side}_thigh", (0, y, -0.15)),
            ("knee", "RevoluteJoint", f"{side}_thigh", f"{side}_shank", (0, 0, -0.15)),
            ("ankle", "FixedJoint", f"{side}_shank", f"{side}_foot", (0.05, 0, -0.1)),
        ):
            joint = getattr(UsdPhysics, kind).Define(stage, f"/walker/{side}_{name}")
            joint.CreateBody0Rel().SetTargets([f"/walker/{parent}"])
            joint.CreateBody1Rel().SetTargets([f"/walker/{child}"])
            joint.CreateLocalPos0Attr(Gf.Vec3f(*at))
            below = np.array(places[child]) - (np.array(places[parent]) + np.array(at))
            joint.CreateLocalPos1Attr(Gf.Vec3f(*(-below).tolist()))
            if kind == "RevoluteJoint":
                joint.CreateAxisAttr("Y")
                joint.CreateLowerLimitAttr(-60.0 if name == "hip" else -100.0)
                joint.CreateUpperLimitAttr(80.0)
    stage.Save()
    return path


@configclass
class _SceneCfg(InteractiveSceneCfg):
    walker: ArticulationCfg | None = None
    contacts: ContactSensorCfg | None = None
    frames: FrameTransformerCfg | None = None


def _start(path, physics="native", fixed=True, actuators=None, index_order=None, **entities):
    props = sim_utils.ArticulationRootPropertiesCfg(fix_root_link=fixed)
    walker = ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Walker",
        spawn=sim_utils.UsdFileCfg(usd_path=str(path), articulation_props=props),
        init_state=ArticulationCfg.InitialStateCfg(pos=(0.0, 0.0, 0.3), joint_pos={".*_hip": 0.1, ".*_knee": -0.2}),
        actuators=actuators or {"all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=40.0, damping=4.0)},
    )
    if index_order is not None:
        walker.index_order = index_order
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=physics, dt=0.002))
    scene = InteractiveScene(_SceneCfg(num_envs=NUM_ENVS, env_spacing=2.0, walker=walker, **entities))
    sim.reset()
    scene.update(0.0)
    return sim, scene


@pytest.fixture(params=["native", pytest.param("warp", marks=pytest.mark.slow)])
def physics(request) -> str:
    return request.param


@pytest.fixture(params=[True, False], ids=["fixed", "free"])
def walker(request, walker_file, physics):
    sim, scene = _start(walker_file, physics, fixed=request.param)
    yield sim, scene["walker"]
    sim.close()


def _mujoco_joints(sim, field):
    """A field of MuJoCo's joints in the order of ``JOINTS``, by name, shape (num_envs, 4)."""
    return torch.tensor(
        [
            [getattr(sim.physics.get_data(e).joint(f"walker/{name}"), field)[0] for name in JOINTS]
            for e in range(NUM_ENVS)
        ]
    ).float()


def test_joints_and_bodies_are_numbered_breadth_first_in_the_order_of_their_joints(walker):
    _, robot = walker
    assert robot.joint_names == robot.data.joint_names == JOINTS
    assert robot.body_names == robot.data.body_names == BODIES
    assert robot.find_joints(["left_.*", "right_hip"]) == ([0, 1, 3], ["right_hip", "left_hip", "left_knee"])
    assert robot.find_bodies(".*_shank") == ([3, 4], ["right_shank", "left_shank"])
    view = robot.root_physx_view
    assert (view.shared_metatype.dof_names, view.shared_metatype.link_names) == (JOINTS, BODIES)


def test_joint_states_go_to_the_joints_of_that_name_and_come_back(walker):
    sim, robot = walker
    position = 0.01 * torch.arange(4) + 0.1 * torch.arange(NUM_ENVS)[:, None]
    velocity = -position
    robot.write_joint_state_to_sim(position, velocity)
    torch.testing.assert_close(robot.data.joint_pos, position)
    torch.testing.assert_close(_mujoco_joints(sim, "qpos"), position)
    torch.testing.assert_close(_mujoco_joints(sim, "qvel"), velocity)
    # two joints of two environments: left_hip and right_knee, which the engine keeps the other way round
    some = torch.tensor([[0.51, 0.52], [0.53, 0.54]])
    robot.write_joint_position_to_sim(some, joint_ids=[1, 2], env_ids=torch.tensor([2, 0]))
    position[2, 1:3], position[0, 1:3] = some[0], some[1]
    torch.testing.assert_close(robot.data.joint_pos, position)
    torch.testing.assert_close(_mujoco_joints(sim, "qpos"), position)


def test_a_targeted_joint_moves_and_its_acceleration_is_its_own(walker):
    sim, robot = walker
    assert not robot.data.joint_acc.any()  # from now on the engine measures it
    target = robot.data.default_joint_pos.clone()
    target[:, JOINTS.index("left_hip")] += 0.3
    robot.set_joint_position_target(target)
    before = robot.data.joint_vel.clone()
    robot.write_data_to_sim()
    control = sim.physics.field("ctrl")
    for i, name in enumerate(JOINTS):
        torch.testing.assert_close(control[:, sim.physics.model.actuator(f"walker/{name}").id], target[:, i])
    sim.physics.step(1)
    robot.update(0.002)
    torch.testing.assert_close(robot.data.joint_vel, _mujoco_joints(sim, "qvel"), atol=1e-5, rtol=1e-4)
    expected = (robot.data.joint_vel - before) / 0.002
    torch.testing.assert_close(robot.data.joint_acc, expected, atol=1e-2, rtol=1e-3)
    assert robot.data.joint_vel.argmax(dim=1).tolist() == [1] * NUM_ENVS


def test_poses_and_velocities_of_bodies_are_those_of_that_name(walker):
    sim, robot = walker
    torch.manual_seed(1)
    robot.write_joint_state_to_sim(0.5 * torch.rand(NUM_ENVS, 4), torch.randn(NUM_ENVS, 4))
    sim.physics.refresh()
    robot.update(0.0)
    model = sim.physics.model
    for env_id in range(NUM_ENVS):
        data = sim.physics.get_data(env_id)
        for i, name in enumerate(BODIES):
            body = model.body(f"walker/{name}").id
            at = torch.tensor(data.xpos[body]).float() + robot._env_origins_w[env_id]
            torch.testing.assert_close(robot.data.body_link_pos_w[env_id, i], at, atol=1e-5, rtol=0)
            quat = torch.tensor(data.xquat[body]).float()
            torch.testing.assert_close(robot.data.body_link_quat_w[env_id, i], quat, atol=1e-5, rtol=0)
            of_com = np.zeros(6)
            mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body, of_com, 0)
            expected = torch.tensor(np.concatenate((of_com[3:], of_com[:3]))).float()
            torch.testing.assert_close(robot.data.body_link_vel_w[env_id, i], expected, atol=1e-4, rtol=1e-4)


def test_masses_colliders_and_wrenches_are_those_of_that_name(walker):
    sim, robot = walker
    model = sim.physics.model
    ids = [model.body(f"walker/{name}").id for name in BODIES]
    masses = torch.tensor([1.0 + STAGE_BODIES.index(name) for name in BODIES]).repeat(NUM_ENVS, 1)
    torch.testing.assert_close(robot.get_masses(), masses)
    torch.testing.assert_close(robot.data.default_mass, masses)
    assert [int(model.geom_bodyid[g]) for g in robot.root_physx_view._shapes] == ids
    robot.write_body_mass_to_sim(torch.tensor([[9.0, 8.0]]), body_ids=[2, 3], env_ids=[1])
    field = sim.physics.randomizable("body_mass")[1].float()
    assert [float(field[i]) for i in ids[1:4]] == [masses[0, 1], 9.0, 8.0]
    robot.write_friction_to_sim(torch.tensor([0.3]), body_ids=[BODIES.index("left_foot")], env_ids=[2])
    friction = sim.physics.randomizable("geom_friction")[2, :, 0]
    assert [int(model.geom_bodyid[g]) for g in (friction - 0.3).abs().lt(1e-6).nonzero()] == [ids[-1]]
    force = torch.tensor([[[0.0, 0.0, 5.0]]]).repeat(NUM_ENVS, 1, 1)
    robot.set_external_force_and_torque(force, torch.zeros_like(force), body_ids=[4], is_global=True)
    robot.write_data_to_sim()
    pushed = sim.physics.field("xfrc_applied").abs().sum(dim=-1)
    assert pushed.nonzero()[:, 1].tolist() == [model.body("walker/left_shank").id] * NUM_ENVS


def test_limits_gains_and_inertia_are_those_of_that_name(walker):
    sim, robot = walker
    model = sim.physics.model
    ranges = torch.tensor(np.array([model.joint(f"walker/{name}").range for name in JOINTS])).float()
    torch.testing.assert_close(robot.data.joint_pos_limits[0], ranges)
    torch.testing.assert_close(robot.data.default_joint_pos[0], torch.tensor([0.1, 0.1, -0.2, -0.2]))
    robot.write_joint_stiffness_to_sim(torch.tensor([[70.0]]), joint_ids=[2], env_ids=[1])
    gain = sim.physics.randomizable("actuator_gainprm")[1, :, 0]
    assert float(gain[model.actuator("walker/right_knee").id]) == 70.0
    assert sorted(gain.tolist()) == [40.0, 40.0, 40.0, 70.0]
    robot.write_joint_armature_to_sim(torch.tensor([[0.5]]), joint_ids=[1], env_ids=[0])
    armature = sim.physics.randomizable("dof_armature")[0]
    assert armature.nonzero().flatten().tolist() == [int(model.joint("walker/left_hip").dofadr[0])]
    if robot.is_fixed_base:
        robot.write_joint_armature_to_sim(0.0)
        dofs = [int(model.joint(f"walker/{name}").dofadr[0]) for name in JOINTS]
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, sim.physics.get_data(0), full)
        inertia = robot.root_physx_view.get_generalized_mass_matrices()[0]
        torch.testing.assert_close(inertia, torch.tensor(full[np.ix_(dofs, dofs)]).float(), atol=1e-4, rtol=1e-4)
        jacobian = robot.root_physx_view.get_jacobians()[0, BODIES.index("left_foot") - 1]
        assert jacobian.abs().sum(dim=0).gt(1e-6).tolist() == [False, True, False, True]  # its own hip and knee


def test_explicit_actuators_see_their_joints_in_that_order(walker_file, physics):
    actuators = {
        "left": IdealPDActuatorCfg(joint_names_expr=["left_.*"], stiffness=30.0, damping=1.0, effort_limit=100.0),
        "right": ImplicitActuatorCfg(joint_names_expr=["right_.*"], stiffness=40.0, damping=4.0),
    }
    sim, scene = _start(walker_file, physics, actuators=actuators)
    robot = scene["walker"]
    left = robot.actuators["left"]
    assert (left.joint_names, left.joint_indices.tolist()) == (["left_hip", "left_knee"], [1, 3])
    target = robot.data.joint_pos + torch.tensor([0.0, 0.1, 0.0, -0.2])
    robot.set_joint_position_target(target)
    robot.write_data_to_sim()
    control = sim.physics.field("ctrl")[0]
    effort = {name: float(control[sim.physics.model.actuator(f"walker/{name}").id]) for name in JOINTS}
    assert effort == pytest.approx({"right_hip": 0.1, "right_knee": -0.2, "left_hip": 3.0, "left_knee": -6.0}, abs=1e-4)
    sim.close()


def test_several_joints_of_one_number_are_set_at_one_write_of_the_engine(walker_file, monkeypatch):
    """Where the orders differ, a step costs one copy of each field that is read, and no other operation."""
    sim, scene = _start(walker_file)
    data = scene["walker"].data
    assert data.joint_pos is data.joint_pos  # gathered once a state
    fields = []
    monkeypatch.setattr(sim.physics, "write", lambda name, values, *rest: fields.append((name, values)))
    scene["walker"].write_data_to_sim()
    (name, values), targets = fields[0], data.joint_pos_target
    assert name == "ctrl"
    assert values.data_ptr() == targets.data_ptr()  # not reordered on the way: the engine's write does
    sim.close()


def test_where_the_orders_agree_joints_are_views_of_the_engine_s_memory(walker_file):
    sim, scene = _start(walker_file, index_order="engine")
    data = scene["walker"].data
    qpos = sim.physics.field("qpos")
    assert data.joint_pos.untyped_storage().data_ptr() == qpos.untyped_storage().data_ptr()
    sim.close()


def test_the_engine_s_order_is_a_setting(walker_file, physics):
    contacts = ContactSensorCfg(prim_path="{ENV_REGEX_NS}/Walker/.*")
    sim, scene = _start(walker_file, physics, index_order="engine", contacts=contacts, frames=_frames())
    robot = scene["walker"]
    assert (robot.joint_names, robot.body_names) == (ENGINE_JOINTS, ENGINE_BODIES)
    assert scene["contacts"].body_names == ENGINE_BODIES
    assert scene["frames"].data.target_frame_names == ["sole", "a_thigh", "toe"]
    robot.write_joint_position_to_sim(torch.tensor([0.1, 0.2, 0.3, 0.4]))
    expected = torch.tensor([0.1, 0.3, 0.2, 0.4]).repeat(NUM_ENVS, 1)  # in the order of JOINTS
    torch.testing.assert_close(_mujoco_joints(sim, "qpos"), expected)
    sim.close()


@pytest.mark.parametrize("value", ["breadth", "depth_first", "", None, 1])
def test_another_order_is_refused_by_name(walker_file, value):
    cfg = _SceneCfg(num_envs=1, env_spacing=2.0)
    cfg.walker = ArticulationCfg(
        prim_path="{ENV_REGEX_NS}/Walker", spawn=sim_utils.UsdFileCfg(usd_path=str(walker_file)), actuators={}
    )
    cfg.walker.index_order = value
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics="native"))
    with pytest.raises(ConfigError, match=rf"scene.walker.index_order.*'{value}'.*'breadth_first'"):
        InteractiveScene(cfg)
    sim.close()


def _frames():
    def frame(body, name):
        return FrameTransformerCfg.FrameCfg(prim_path=f"{{ENV_REGEX_NS}}/Walker/{body}", name=name)

    return FrameTransformerCfg(
        prim_path="{ENV_REGEX_NS}/Walker/trunk",
        target_frames=[frame("right_foot", "sole"), frame("left_thigh", "a_thigh"), frame("right_foot", "toe")],
    )


def test_sensors_over_several_bodies_follow_the_stage_and_frames_their_paths(walker_file, physics):
    """PhysX's views find prims in the order of the stage; Isaac Lab's frame transformer sorts its bodies' paths."""
    contacts = ContactSensorCfg(prim_path="{ENV_REGEX_NS}/Walker/.*_(foot|shank)", track_pose=True)
    sim, scene = _start(walker_file, physics, contacts=contacts, frames=_frames())
    robot, sensor = scene["walker"], scene["contacts"]
    assert sensor.body_names == ["left_foot", "left_shank", "right_foot", "right_shank"]
    assert sensor.find_bodies(".*_foot")[0] == [0, 2]
    places = [BODIES.index(name) for name in sensor.body_names]
    torch.testing.assert_close(sensor.data.pos_w, robot.data.body_link_pos_w[:, places])
    frames = scene["frames"].data
    assert frames.target_frame_names == ["a_thigh", "sole", "toe"]
    places = [BODIES.index(name) for name in ("left_thigh", "right_foot", "right_foot")]
    torch.testing.assert_close(frames.target_pos_w, robot.data.body_link_pos_w[:, places])
    sim.close()
