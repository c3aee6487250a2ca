"""Roots: their default state, what is written to them, and the pose of one that is fixed to the world."""

import re

import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.assets import ArticulationCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError
from lift_lab_assets import FRANKA_PANDA_CFG

NUM_ENVS = 3


@configclass
class _SceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg | None = None
    box: RigidObjectCfg | None = None


@pytest.fixture(params=["native", pytest.param("warp", marks=pytest.mark.slow)])
def start(request):
    robot = FRANKA_PANDA_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
    robot.init_state.pos = (0.2, 0.0, 0.5)

    def make(robot_rot=(0.6, 0.0, 0.8, 0.0), **box):
        robot.init_state.rot = robot_rot
        rigid = sim_utils.RigidBodyPropertiesCfg(**box)
        cfg = RigidObjectCfg(
            prim_path="{ENV_REGEX_NS}/Box",
            init_state=RigidObjectCfg.InitialStateCfg(
                pos=(1.0, 0.0, 2.0), rot=(0.6, 0.8, 0.0, 0.0), lin_vel=(0.5, 0.0, 0.0), ang_vel=(0.0, 0.0, 3.0)
            ),
            spawn=sim_utils.CuboidCfg(
                size=(0.2, 0.1, 0.1), rigid_props=rigid, mass_props=sim_utils.MassPropertiesCfg(mass=0.6)
            ),
        )
        if box.get("kinematic_enabled"):
            cfg.init_state.lin_vel = cfg.init_state.ang_vel = (0.0, 0.0, 0.0)
        sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=request.param, dt=0.002))
        scene = InteractiveScene(_SceneCfg(num_envs=NUM_ENVS, env_spacing=2.0, robot=robot, box=cfg))
        sim.reset()
        scene.update(0.0)
        return sim, scene

    return make


@pytest.mark.parametrize("kinematic", [False, True])
def test_a_root_is_put_into_its_default_state_where_that_is_asked_for(start, kinematic):
    _, scene = start(kinematic_enabled=kinematic)
    box = scene["box"]
    elsewhere = torch.tensor([[4.0, 5.0, 6.0, 1.0, 0.0, 0.0, 0.0]]).repeat(NUM_ENVS, 1)
    box.write_root_pose_to_sim(elsewhere)
    box.data.default_root_state[2, 2] = 3.0
    box.write_default_root_state_to_sim(torch.tensor([0, 2]))
    expected = scene.env_origins + torch.tensor([[1.0, 0.0, 2.0], [0.0, 0.0, 0.0], [1.0, 0.0, 3.0]])
    expected[1] = elsewhere[1, :3]
    torch.testing.assert_close(box.data.root_pos_w, expected)
    torch.testing.assert_close(box.data.root_quat_w[[0, 2]], torch.tensor([[0.6, 0.8, 0.0, 0.0]]).repeat(2, 1))
    velocity = torch.zeros(6) if kinematic else torch.tensor([0.5, 0.0, 0.0, 0.0, 0.0, 3.0])
    torch.testing.assert_close(box.data.root_vel_w[[0, 2]], velocity.repeat(2, 1), atol=1e-6, rtol=0)
    box.write_default_root_state_to_sim()
    torch.testing.assert_close(box.data.root_pos_w[1], scene.env_origins[1] + torch.tensor([1.0, 0.0, 2.0]))


def test_the_pose_of_a_standing_root_is_computed_once_and_that_of_a_free_one_at_every_state(start):
    sim, scene = start()
    data, box = scene["robot"].data, scene["box"].data
    with torch.inference_mode():
        pos_w, quat_w, of_box = data.root_pos_w, data.root_quat_w, box.root_pos_w
    torch.testing.assert_close(pos_w, scene.env_origins + torch.tensor([0.2, 0.0, 0.5]))
    torch.testing.assert_close(quat_w, torch.tensor([[0.6, 0.0, 0.8, 0.0]]).repeat(NUM_ENVS, 1))
    sim.physics.step(5)
    scene.update(0.01)
    assert data.root_pos_w is pos_w
    assert data.root_quat_w is quat_w
    assert (box.root_pos_w != of_box).any(dim=1).all()


@pytest.mark.parametrize("what", ["the pose", "the origins"])
def test_a_kept_pose_is_computed_anew_once_somebody_wrote_into_it(start, what):
    _, scene = start()
    data = scene["robot"].data
    before = data.root_pos_w.clone()
    if what == "the pose":
        data.root_pos_w[1] += 1.0
        expected = before
    else:
        scene.env_origins[1] += 1.0
        expected = before + torch.tensor([[0.0], [1.0], [0.0]])
    scene.update(0.01)
    torch.testing.assert_close(data.root_pos_w, expected)
    scene.update(0.01)
    torch.testing.assert_close(data.root_pos_w, expected)


@pytest.mark.parametrize(("robot_rot", "aligned"), [((1.0, 0.0, 0.0, 0.0), True), ((0.6, 0.0, 0.8, 0.0), False)])
def test_only_a_standing_root_whose_axes_are_the_worlds_is_aligned(start, robot_rot, aligned):
    sim, scene = start(robot_rot=robot_rot)
    robot, box = scene["robot"].data, scene["box"]
    box.write_root_pose_to_sim(torch.tensor([[0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0]]).repeat(NUM_ENVS, 1))
    assert robot.root_is_aligned is aligned
    assert box.data.root_is_aligned is False  # now it is turned like the world, but it can turn
    robot.root_quat_w[1] = torch.tensor([0.0, 1.0, 0.0, 0.0])  # a slip that the next state mends
    sim.physics.step(1)
    scene.update(0.002)
    assert robot.root_is_aligned is aligned
    torch.testing.assert_close(robot.root_quat_w[1], torch.tensor(robot_rot))


_POSE = [0.5, -0.2, 1.5, 0.5, 0.5, -0.5, 0.5]
_VELOCITY = [0.1, 0.2, 0.3, -0.4, 0.5, 0.6]
_WRITES = {
    "write_root_pose_to_sim": (_POSE, "root_link_pose_w"),
    "write_root_link_pose_to_sim": (_POSE, "root_link_pose_w"),
    "write_root_com_pose_to_sim": (_POSE, "root_com_pose_w"),
    "write_root_velocity_to_sim": (_VELOCITY, "root_com_vel_w"),
    "write_root_com_velocity_to_sim": (_VELOCITY, "root_com_vel_w"),
    "write_root_link_velocity_to_sim": (_VELOCITY, "root_link_vel_w"),
    "write_root_state_to_sim": (_POSE + _VELOCITY, "root_state_w"),
    "write_root_link_state_to_sim": (_POSE + _VELOCITY, "root_link_state_w"),
    "write_root_com_state_to_sim": (_POSE + _VELOCITY, "root_com_state_w"),
}


@pytest.fixture(scope="module", params=["native", pytest.param("warp", marks=pytest.mark.slow)])
def free(request):
    """A box and an arm whose roots are free; the tests write what they read."""
    robot = FRANKA_PANDA_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
    robot.spawn.articulation_props = sim_utils.ArticulationRootPropertiesCfg(fix_root_link=False)
    box = RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Box",
        spawn=sim_utils.CuboidCfg(
            size=(0.2, 0.1, 0.1),
            rigid_props=sim_utils.RigidBodyPropertiesCfg(),
            mass_props=sim_utils.MassPropertiesCfg(mass=0.6),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=request.param, dt=0.002))
    scene = InteractiveScene(_SceneCfg(num_envs=NUM_ENVS, env_spacing=2.0, robot=robot, box=box))
    sim.reset()
    scene.update(0.0)
    yield scene
    sim.close()


@pytest.mark.parametrize("asset", ["box", "robot"])
@pytest.mark.parametrize("method", _WRITES)
def test_one_row_or_vector_is_written_into_every_environment(free, asset, method):
    values, name = _WRITES[method]
    write, data = getattr(free[asset], method), free[asset].data
    one = torch.tensor(values)
    for given in (one, one[None], values, one.double().numpy(), one.repeat(NUM_ENVS, 1)):
        free[asset].write_default_root_state_to_sim()
        write(given)
        torch.testing.assert_close(getattr(data, name), one.repeat(NUM_ENVS, 1), atol=1e-5, rtol=0)
    free[asset].write_default_root_state_to_sim()
    before = getattr(data, name)[1].clone()
    write(one, [2, 0])
    torch.testing.assert_close(getattr(data, name)[[0, 2]], one.repeat(2, 1), atol=1e-5, rtol=0)
    torch.testing.assert_close(getattr(data, name)[1], before)


@pytest.mark.parametrize("asset", ["box", "robot"])
@pytest.mark.parametrize("method", _WRITES)
def test_a_shape_that_does_not_fit_is_named_and_nothing_is_written(free, asset, method):
    values, name = _WRITES[method]
    write, width = getattr(free[asset], method), len(values)
    free[asset].write_default_root_state_to_sim()
    before = getattr(free[asset].data, name).clone()
    for shape, ids, wanted in (
        ((width + 1,), None, (NUM_ENVS, width)),
        ((2, width), None, (NUM_ENVS, width)),
        ((NUM_ENVS, width), [0, 1], (2, width)),
        ((NUM_ENVS, 1, width), None, (NUM_ENVS, width)),
        ((NUM_ENVS, width - 1), None, (NUM_ENVS, width)),
    ):
        message = f"'{asset}'.{method}: values of shape {shape} do not fit {wanted}"
        with pytest.raises(ConfigError, match=re.escape(message)):
            write(torch.zeros(shape), ids)
    with pytest.raises(ConfigError, match=rf"'{asset}'.{method}: expected numbers .*'here'"):
        write("here")
    torch.testing.assert_close(getattr(free[asset].data, name), before)


def test_a_number_is_a_velocity_and_no_pose(free):
    box = free["box"]
    box.write_root_velocity_to_sim(torch.ones(6))
    box.write_root_velocity_to_sim(0.0)
    assert not box.data.root_com_vel_w.any()
    with pytest.raises(ConfigError, match=r"values of shape \(\) do not fit \(3, 7\)"):
        box.write_root_pose_to_sim(0.0)


def test_masses_wrenches_and_targets_broadcast_and_name_shapes_too(free):
    robot = free["robot"]
    robot.write_body_mass_to_sim(torch.tensor([1.5, 2.5]), body_ids=[1, 3], env_ids=[2])
    torch.testing.assert_close(robot.get_masses()[2, [1, 3]], torch.tensor([1.5, 2.5]))
    robot.set_external_force_and_torque(torch.tensor([0.0, 0.0, 2.0]), torch.zeros(3), body_ids=[2])
    assert robot._force_b[:, 2, 2].tolist() == [2.0] * NUM_ENVS
    robot.write_joint_state_to_sim([0.1, -0.2, 0.3], 0.0, joint_ids=[0, 1, 2])
    before = robot.data.joint_pos.clone()
    torch.testing.assert_close(before[:, :3], torch.tensor([0.1, -0.2, 0.3]).repeat(NUM_ENVS, 1))
    for name, call in (
        ("write_body_mass_to_sim", lambda: robot.write_body_mass_to_sim(torch.ones(2), body_ids=[0, 1, 2])),
        ("set_external_force_and_torque", lambda: robot.set_external_force_and_torque(*torch.ones(2, 2, 4))),
        ("write_joint_state_to_sim", lambda: robot.write_joint_state_to_sim(0.2, torch.ones(2), joint_ids=[0, 1, 2])),
        ("write_joint_velocity_to_sim", lambda: robot.write_joint_velocity_to_sim(torch.ones(2, 9))),
        ("joint_pos_target", lambda: robot.set_joint_position_target(torch.ones(2, 9))),
        ("joint_stiffness", lambda: robot.write_joint_stiffness_to_sim(torch.ones(3), joint_ids=[0, 1])),
    ):
        with pytest.raises(ConfigError, match=rf"'robot'.{name}: values of shape \(.*\) do not fit \(3, .*\)"):
            call()
    torch.testing.assert_close(robot.data.joint_pos, before)  # not even the half that fits was written


@pytest.mark.parametrize("asset", ["box", "robot"])
@pytest.mark.parametrize("method", _WRITES)
def test_numbers_of_every_type_are_the_same_state(free, asset, method):
    values, name = _WRITES[method]
    write, data = getattr(free[asset], method), free[asset].data
    double = torch.tensor(values, dtype=torch.float64)
    whole = torch.tensor([1, 2, 3, 0, 1, 0, 0, 1, 2, 3, 4, 5, 6][: len(values)])  # with an orientation, if there is one
    for given, expected, tolerance in (
        (double, double, 1e-5),
        (double.repeat(NUM_ENVS, 1), double, 1e-5),
        (double.half(), double, 2e-3),
        (whole, whole, 1e-5),
        (whole.numpy(), whole, 1e-5),
    ):
        free[asset].write_default_root_state_to_sim()
        write(given)
        expected = expected.float().repeat(NUM_ENVS, 1)
        torch.testing.assert_close(getattr(data, name), expected, atol=tolerance, rtol=0)
    before = getattr(data, name).clone()
    for wrong in (double.bool(), double.to(torch.complex64)):
        with pytest.raises(ConfigError, match=rf"'{asset}'.{method}: expected real numbers, got {wrong.dtype}"):
            write(wrong)
    torch.testing.assert_close(getattr(data, name), before)


_WRONG_IDS = {
    "id 3 is out of range: there are 3": [0, 3],
    "id -4 is out of range": torch.tensor([0, -4]),
    r"one dimension, got shape \(2, 1\)": torch.tensor([[0], [1]]),
    "integers, got 'all'": "all",
    "nonzero": torch.tensor([True, False, True]),
}


@pytest.mark.parametrize("told", _WRONG_IDS)
def test_environments_and_joints_that_are_not_there_are_refused(free, told):
    robot = free["robot"]
    before = robot.data.root_state_w.clone(), robot.data.joint_pos.clone(), robot.data.joint_pos_target.clone()
    for method, (values, _) in _WRITES.items():
        with pytest.raises(ConfigError, match=f"'robot': env_ids: .*{told}"):
            getattr(robot, method)(values, env_ids=_WRONG_IDS[told])
    joint_ids = _WRONG_IDS[told]
    if "range" in told:
        joint_ids, told = [0, robot.num_joints], f"id {robot.num_joints} is out of range"
    for method in ("write_joint_position_to_sim", "set_joint_position_target", "write_joint_armature_to_sim"):
        with pytest.raises(ConfigError, match=told):
            getattr(robot, method)(0.1, joint_ids=joint_ids)
    after = robot.data.root_state_w, robot.data.joint_pos, robot.data.joint_pos_target
    for was, now in zip(before, after, strict=True):
        torch.testing.assert_close(now, was)


def test_targets_and_gains_take_what_joint_states_take(free):
    robot = free["robot"]
    for given in ([0.1] * robot.num_joints, torch.full((robot.num_joints,), 0.1).double().numpy(), 0.1):
        for method, name in (("set_joint_position_target", "pos_target"), ("write_joint_armature_to_sim", "armature")):
            getattr(robot, method)(0.0)
            getattr(robot, method)(given)
            torch.testing.assert_close(getattr(robot.data, f"joint_{name}"), torch.full((3, robot.num_joints), 0.1))
    with pytest.raises(ConfigError, match=r"'robot'.joint_pos_target: expected numbers .* got None"):
        robot.set_joint_position_target(None)


@pytest.mark.parametrize(
    ("method", "wrong"),
    [
        *((f"write_joint_{name}_to_sim", -1.0) for name in ("stiffness", "damping", "armature", "effort_limit")),
        *((f"write_joint_{name}_to_sim", float("nan")) for name in ("stiffness", "damping", "armature")),
        ("write_joint_friction_coefficient_to_sim", -1.0),
        ("write_joint_viscous_friction_coefficient_to_sim", float("inf")),
        ("write_joint_velocity_limit_to_sim", -1.0),
        ("write_joint_position_limit_to_sim", [1.0, -1.0]),
        ("write_body_mass_to_sim", float("nan")),
        ("write_friction_to_sim", -1.0),
        ("write_friction_to_sim", [0.5, 0.5]),
        ("write_collider_margin_to_sim", float("nan")),
    ],
)
def test_properties_that_nothing_can_have_are_refused(free, method, wrong):
    robot = free["robot"]
    names = ("stiffness", "damping", "armature", "friction_coeff", "vel_limits", "pos_limits", "effort_limits")
    before = [getattr(robot.data, f"joint_{name}").clone() for name in names]
    ids = {"joint_ids": [0, 1]} if "joint" in method else {}
    with pytest.raises(ConfigError, match="'robot'"):
        getattr(robot, method)(wrong, **ids)
    for name, value in zip(names, before, strict=True):
        torch.testing.assert_close(getattr(robot.data, f"joint_{name}"), value)
    assert robot.get_masses().isfinite().all()


def test_wrenches_and_properties_of_colliders_take_lists_and_numbers(free):
    box = free["box"]
    box.set_external_force_and_torque([[0.0, 0.0, 1.0]], [[0.0, 0.0, 0.0]])
    torch.testing.assert_close(box._force_b[:, 0], torch.tensor([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]).repeat(NUM_ENVS, 1))
    box.set_external_force_and_torque(torch.empty(0, 3), torch.empty(0, 3))
    box.write_friction_to_sim(0.25)
    box.write_friction_to_sim([0.5], env_ids=[2])
    friction = box.root_physx_view.get_material_properties()
    assert friction[:, 0, 0].tolist() == [0.25, 0.25, 0.5]
    with pytest.raises(ConfigError, match="id 3 is out of range"):
        box.root_physx_view.set_masses(box.root_physx_view.get_masses(), [3])
    with pytest.raises(ConfigError, match="not finite"):
        box.root_physx_view.set_inertias(box.root_physx_view.get_inertias() * float("nan"), [0])
