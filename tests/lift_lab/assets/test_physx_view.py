"""What task files ask PhysX's views for, against MuJoCo's own numbers, on both engines."""

import mujoco
import numpy as np
import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets import ArticulationCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError, UnknownAttributeError
from lift_lab_assets.robots.franka import FRANKA_PANDA_CFG

NUM_ENVS = 3
HAND = "panda_hand"


@configclass
class _SceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg = FRANKA_PANDA_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")
    box: RigidObjectCfg = RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Box",
        init_state=RigidObjectCfg.InitialStateCfg(pos=(1.0, 0.0, 2.0), rot=(0.5, 0.5, -0.5, 0.5)),
        spawn=sim_utils.CuboidCfg(
            size=(0.2, 0.1, 0.1),
            rigid_props=sim_utils.RigidBodyPropertiesCfg(),
            mass_props=sim_utils.MassPropertiesCfg(mass=0.6),
            collision_props=sim_utils.CollisionPropertiesCfg(),
        ),
    )


def _start(physics: str, fix_root: bool = True):
    cfg = _SceneCfg(num_envs=NUM_ENVS, env_spacing=2.0)
    cfg.robot.spawn.articulation_props = sim_utils.ArticulationRootPropertiesCfg(fix_root_link=fix_root)
    cfg.robot.spawn.rigid_props = sim_utils.RigidBodyPropertiesCfg(disable_gravity=False)
    cfg.robot.actuators = {"all": ImplicitActuatorCfg(joint_names_expr=[".*"], stiffness=10.0, damping=1.0)}
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu", physics=physics, dt=0.002))
    scene = InteractiveScene(cfg)
    sim.reset()
    torch.manual_seed(2)
    robot = scene["robot"]
    robot.write_joint_position_to_sim(robot.data.default_joint_pos + 0.2 * torch.rand(NUM_ENVS, robot.num_joints))
    sim.physics.refresh()
    scene.update(0.0)
    return sim, scene


@pytest.fixture(params=["native", pytest.param("warp", marks=pytest.mark.slow)])
def physics(request) -> str:
    return request.param


@pytest.fixture
def started(physics):
    sim, scene = _start(physics)
    yield sim, scene
    sim.close()


def _body(model, asset, name):
    return model.body(f"{asset}/{name}").id


def test_poses_have_the_real_part_last_and_the_world_s_origin(started):
    sim, scene = started
    box, robot = scene["box"].root_physx_view, scene["robot"]
    expected = torch.cat((scene.env_origins + torch.tensor([1.0, 0.0, 2.0]), torch.zeros(NUM_ENVS, 4)), dim=1)
    expected[:, 3:] = torch.tensor([0.5, -0.5, 0.5, 0.5])
    torch.testing.assert_close(box.get_transforms(), expected)
    links = robot.root_physx_view.get_link_transforms()
    hand = robot.body_names.index(HAND)
    for env_id in range(NUM_ENVS):
        data = sim.physics.get_data(env_id)
        body = data.body(f"robot/{HAND}")
        at = torch.tensor(body.xpos) + scene.env_origins[env_id]
        torch.testing.assert_close(links[env_id, hand, :3].double(), at.double(), atol=1e-5, rtol=0)
        torch.testing.assert_close(
            links[env_id, hand, 3:].double(), torch.tensor(body.xquat[[1, 2, 3, 0]]), atol=1e-5, rtol=0
        )


def test_jacobians_inertia_and_gravity_of_a_fixed_arm_are_mujocos(started):
    sim, scene = started
    robot = scene["robot"]
    view = robot.root_physx_view
    model = sim.physics.model
    assert view.shared_metatype.fixed_base
    jacobians, inertias = view.get_jacobians(), view.get_generalized_mass_matrices()
    gravity = view.get_gravity_compensation_forces()
    assert jacobians.shape == (NUM_ENVS, robot.num_bodies - 1, 6, robot.num_joints)
    body, dofs = _body(model, "robot", HAND), robot._dof_ids
    for env_id in range(NUM_ENVS):
        data = sim.physics.get_data(env_id)
        linear, angular = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        mujoco.mj_jacBody(model, data, linear, angular, body)
        expected = torch.tensor(np.concatenate((linear, angular))[:, dofs])
        mine = jacobians[env_id, robot.body_names.index(HAND) - 1].double()
        torch.testing.assert_close(mine, expected, atol=1e-5, rtol=0)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        torch.testing.assert_close(
            inertias[env_id].double(), torch.tensor(full[np.ix_(dofs, dofs)]), atol=1e-4, rtol=1e-4
        )
        holding = torch.tensor(data.qfrc_bias[dofs] - data.qfrc_gravcomp[dofs])
        torch.testing.assert_close(gravity[env_id].double(), holding, atol=1e-3, rtol=1e-3)
    assert gravity.abs().max() > 1.0


def test_jacobians_of_a_free_arm_turn_velocities_of_root_and_joints_into_those_of_bodies(physics):
    sim, scene = _start(physics, fix_root=False)
    robot = scene["robot"]
    view = robot.root_physx_view
    robot.write_root_link_velocity_to_sim(torch.randn(NUM_ENVS, 6))
    robot.write_joint_velocity_to_sim(torch.randn(NUM_ENVS, robot.num_joints))
    sim.physics.forward()
    scene.update(0.0)
    motion = torch.cat((robot.data.root_link_vel_w, robot.data.joint_vel), dim=1)
    velocities = torch.einsum("nbfj,nj->nbf", view.get_jacobians(), motion)
    torch.testing.assert_close(velocities, robot.data.body_link_vel_w, atol=1e-4, rtol=1e-4)
    with pytest.raises(ConfigError, match="fixed root"):
        view.get_generalized_mass_matrices()
    sim.close()


def test_what_is_set_in_one_environment_is_the_model_of_that_environment(started):
    sim, scene = started
    view = scene["box"].root_physx_view
    body = _body(sim.physics.model, "box", "Box")
    masses, inertias, materials = view.get_masses(), view.get_inertias(), view.get_material_properties()
    assert masses.shape == (NUM_ENVS, 1)
    assert materials.shape == (NUM_ENVS, view.max_shapes, 3)
    assert view.max_shapes == 1
    solid = 0.6 / 12 * torch.tensor([0.02, 0.05, 0.05])  # of a cuboid of 0.2, 0.1 and 0.1 m, about its own axes
    assert inertias.shape == (NUM_ENVS, 9)
    torch.testing.assert_close(inertias[0], torch.diag(solid).flatten(), atol=1e-8, rtol=1e-5)
    torch.testing.assert_close(scene["box"].data.default_inertia, inertias)
    principal = torch.tensor(sim.physics.model.body_inertia[body], dtype=torch.float32)
    view.set_masses(masses * 2.0, torch.tensor([1]))
    view.set_inertias(inertias * 3.0, torch.tensor([1]))
    materials[..., :2] = 0.35
    view.set_material_properties(materials, torch.tensor([1]))
    for env_id, (mass, inertia, friction) in enumerate(((0.6, 1.0, 1.0), (1.2, 3.0, 0.35), (0.6, 1.0, 1.0))):
        sim.physics.get_data(env_id)
        field = sim.physics.randomizable
        assert float(field("body_mass")[env_id, body]) == pytest.approx(mass)
        torch.testing.assert_close(field("body_inertia")[env_id, body].float(), inertia * principal)
        shape = scene["box"]._geom_ids[0]
        assert float(field("geom_friction")[env_id, shape, 0]) == pytest.approx(friction)
    torch.testing.assert_close(view.get_masses().flatten(), torch.tensor([0.6, 1.2, 0.6]))


def test_views_have_physx_s_shapes_and_inertias_are_in_the_link_s_axes(started):
    """PhysX gives R diag(I) R', with the axes of get_coms; one row of a rigid object, one for each link of a robot."""
    sim, scene = started
    robot, box = scene["robot"], scene["box"]
    model = sim.physics.model
    expected = []
    for name in robot.body_names:
        body = _body(model, "robot", name)
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, model.body_iquat[body])
        axes = axes.reshape(3, 3)
        expected.append((axes @ np.diag(model.body_inertia[body]) @ axes.T).flatten())
    expected = torch.tensor(np.array(expected)).float().repeat(NUM_ENVS, 1, 1)
    assert (expected[0, :, [1, 2, 5]].abs() > 1e-6).any()  # or the axes would not be tried
    view = robot.root_physx_view
    torch.testing.assert_close(view.get_inertias(), expected, atol=1e-7, rtol=1e-5)
    torch.testing.assert_close(robot.data.default_inertia, expected, atol=1e-7, rtol=1e-5)
    of_box = box.root_physx_view
    assert (view.get_masses().shape, of_box.get_masses().shape) == ((NUM_ENVS, robot.num_bodies), (NUM_ENVS, 1))
    assert (view.get_coms().shape, of_box.get_coms().shape) == ((NUM_ENVS, robot.num_bodies, 7), (NUM_ENVS, 7))
    assert (of_box.get_inertias().shape, box.data.default_inertia.shape) == ((NUM_ENVS, 9), (NUM_ENVS, 9))
    assert box.data.default_mass.shape == (NUM_ENVS, 1)
    view.set_inertias(2.0 * view.get_inertias(), torch.tensor([1]))
    factors = torch.tensor([1.0, 2.0, 1.0])[:, None, None]
    torch.testing.assert_close(view.get_inertias(), factors * expected, atol=1e-6, rtol=1e-4)
    of_box.set_inertias((3.0 * of_box.get_inertias()).view(NUM_ENVS, 1, 9), torch.tensor([2]))
    factors = torch.tensor([[1.0], [1.0], [3.0]])
    torch.testing.assert_close(of_box.get_inertias(), factors * box.data.default_inertia)


def test_centres_of_mass_move_and_their_axes_do_not(started):
    sim, scene = started
    robot = scene["robot"]
    view = robot.root_physx_view
    hand = robot.body_names.index(HAND)
    body = _body(sim.physics.model, "robot", HAND)
    coms = view.get_coms()
    before = torch.tensor(sim.physics.model.body_ipos[body], dtype=torch.float32)
    torch.testing.assert_close(coms[0, hand, :3], before)
    moved = coms.clone()
    moved[:, hand, 0] += 0.01
    view.set_coms(moved, torch.tensor([2]))
    now = sim.physics.randomizable("body_ipos")[:, body].float()
    torch.testing.assert_close(now[2] - before, torch.tensor([0.01, 0.0, 0.0]))
    torch.testing.assert_close(now[0], before)
    moved[:, hand, 3:] = torch.tensor([1.0, 0.0, 0.0, 0.0])
    with pytest.raises(ConfigError, match="cannot turn"):
        view.set_coms(moved, torch.tensor([2]))


def test_joint_readings_are_the_asset_s(started):
    _, scene = started
    robot = scene["robot"]
    view = robot.root_physx_view
    assert view.shared_metatype.dof_names == robot.joint_names
    assert view.max_links == robot.num_bodies
    finger = robot.joint_names.index("panda_finger_joint1")
    assert view.get_dof_limits()[0, finger].tolist() == pytest.approx([0.0, 0.04])
    for name, value in (("positions", robot.data.joint_pos), ("stiffnesses", robot.data.joint_stiffness)):
        read = getattr(view, f"get_dof_{name}")()
        torch.testing.assert_close(read, value)
        read += 1.0
        assert not torch.equal(read, value)


def test_what_is_missing_or_of_a_wrong_size_is_named():
    sim, scene = _start("native")
    view = scene["robot"].root_physx_view
    with pytest.raises(UnknownAttributeError, match="get_jacobians"):
        _ = view.get_jacobian
    with pytest.raises(ConfigError, match=r"'box'.root_physx_view: .* \(3, 1\), got \(1, 1\)"):
        scene["box"].root_physx_view.set_masses(torch.ones(1, 1), torch.tensor([0]))
    box = scene["box"].root_physx_view
    with pytest.raises(ConfigError, match="cannot turn principal axes"):
        box.set_inertias(box.get_inertias() + 0.1, torch.tensor([0]))
    with pytest.raises(ConfigError, match=r"negative \(-"):
        box.set_inertias(-box.get_inertias(), torch.tensor([0]))
    with pytest.raises(ConfigError, match=r"\(3, 7\), got \(7, 3\)"):
        box.set_coms(box.get_coms().T, torch.tensor([0]))
    with pytest.raises(ConfigError, match=r"\(3, 11, 9\), got \(3, 9\)"):
        view.set_inertias(box.get_inertias(), torch.tensor([0]))
    sim.close()
