"""A deformable object has the state of its nodes, in Isaac Lab's terms, and behaves as a soft body."""

import math
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
import torch
from pxr import Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.assets import AssetBaseCfg, DeformableObjectCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sim.physics import make_physics
from lift_lab.usd import UsdImportError, load
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError, UnknownAttributeError
from lift_lab_assets.files import ASSETS_USD_DIR

SIZE = (0.06, 0.04, 0.08)
DT = 0.005


def soft_box(**changes) -> DeformableObjectCfg:
    spawn = sim_utils.MeshCuboidCfg(
        size=SIZE,
        deformable_props=sim_utils.DeformableBodyPropertiesCfg(),
        mass_props=sim_utils.MassPropertiesCfg(mass=0.3),
        physics_material=sim_utils.DeformableBodyMaterialCfg(youngs_modulus=5e4, poissons_ratio=0.3),
    )
    state = DeformableObjectCfg.InitialStateCfg(pos=(0.5, -0.2, 1.0))
    cfg = DeformableObjectCfg(prim_path="{ENV_REGEX_NS}/Sponge", init_state=state, spawn=spawn)
    for name, value in changes.items():
        setattr(cfg.spawn, name, value)
    return cfg


@configclass
class SceneCfg(InteractiveSceneCfg):
    num_envs = 3
    env_spacing = 2.0
    ground: AssetBaseCfg | None = None
    object: DeformableObjectCfg | RigidObjectCfg | None = None


def start(cfg, ground=False, integrator="discrete") -> InteractiveScene:
    settings = sim_utils.SimulationCfg(device="cpu", dt=DT, num_threads=1)
    settings.mujoco.integrator = integrator
    sim = sim_utils.SimulationContext(settings)
    plane = AssetBaseCfg(prim_path="/World/ground", spawn=sim_utils.GroundPlaneCfg()) if ground else None
    scene = InteractiveScene(SceneCfg(object=cfg, ground=plane))
    sim.reset()
    return scene


def step(scene: InteractiveScene, count: int) -> None:
    scene.write_data_to_sim()
    scene.sim.physics.step(count)
    scene.update(count * DT)


@pytest.fixture(autouse=True)
def _no_simulation_is_left():
    yield
    sim_utils.SimulationContext.clear_instance()


def test_nodes_stand_at_the_corners_of_the_box_where_the_config_puts_it():
    half = math.sqrt(0.5)
    cfg = soft_box()
    cfg.init_state.rot = (half, 0.0, 0.0, half)  # a quarter turn about z
    scene = start(cfg)
    soft = scene["object"]
    assert scene.deformable_objects == {"object": soft}
    assert soft.max_sim_vertices_per_body == 8
    nodes = soft.data.nodal_pos_w - scene.env_origins[:, None]
    centre, edges = torch.tensor([0.5, -0.2, 1.0]), torch.tensor([SIZE[1], SIZE[0], SIZE[2]])
    torch.testing.assert_close(nodes.mean(dim=1), centre.expand(3, 3))
    # the points lie a radius, a fortieth of the shortest edge, inside the surface
    span = nodes.amax(dim=1) - nodes.amin(dim=1)
    torch.testing.assert_close(span, (edges - 2 * 0.025 * min(SIZE)).expand(3, 3), atol=1e-6, rtol=0)
    torch.testing.assert_close(soft.data.root_pos_w, scene.env_origins + centre)
    assert not soft.data.nodal_vel_w.any()


def test_its_mass_is_the_bodys_and_it_falls_freely_without_deforming():
    scene = start(soft_box())
    soft, model = scene["object"], scene.sim.model
    assert sum(model.body_mass) == pytest.approx(0.3, rel=1e-5)
    before = soft.data.nodal_pos_w.clone()
    steps = 40
    step(scene, steps)
    # semi-implicit Euler: velocity first, then position with it
    fall = 9.81 * DT**2 * steps * (steps + 1) / 2
    expected = before - torch.tensor([0.0, 0.0, fall])
    torch.testing.assert_close(soft.data.nodal_pos_w, expected, atol=1e-4, rtol=0)
    torch.testing.assert_close(
        soft.data.root_vel_w, torch.tensor([[0.0, 0.0, -9.81 * DT * steps]] * 3), atol=1e-3, rtol=0
    )


def test_what_is_written_is_read_back_in_the_environments_it_was_written_to():
    cfg = soft_box()
    cfg.init_state.rot = (0.5, 0.5, 0.5, 0.5)
    scene = start(cfg)
    soft = scene["object"]
    state = soft.data.nodal_state_w.clone()
    wanted = state[1:] + torch.randn(2, 8, 6, generator=torch.Generator().manual_seed(3)) * 0.01
    soft.write_nodal_state_to_sim(wanted, env_ids=[1, 2])
    torch.testing.assert_close(soft.data.nodal_state_w[1:], wanted, atol=1e-6, rtol=0)
    assert torch.equal(soft.data.nodal_state_w[0], state[0])
    scene.sim.physics.refresh()
    data = scene.sim.physics.get_data(1)
    nodes = data.xpos[[scene.sim.model.body(f"object/Sponge_{i}_{j}_{k}").id for i, j, k in CORNERS]]
    expected = wanted[0, :, :3] - scene.env_origins[1]
    torch.testing.assert_close(torch.tensor(nodes, dtype=torch.float32), expected, atol=1e-6, rtol=0)


def test_nodes_of_one_body_are_written_into_every_environment_and_shapes_are_named():
    scene = start(soft_box())
    soft = scene["object"]
    nodes = torch.randn(8, 6, generator=torch.Generator().manual_seed(4)) * 0.01
    soft.write_nodal_state_to_sim(nodes)
    torch.testing.assert_close(soft.data.nodal_state_w, nodes.repeat(3, 1, 1), atol=1e-6, rtol=0)
    soft.write_nodal_pos_to_sim(nodes[:, 3:], env_ids=[1])
    torch.testing.assert_close(soft.data.nodal_pos_w[1], nodes[:, 3:], atol=1e-6, rtol=0)
    soft.write_nodal_velocity_to_sim(torch.tensor([0.0, 0.0, 0.5]))
    torch.testing.assert_close(soft.data.nodal_vel_w, torch.tensor([0.0, 0.0, 0.5]).repeat(3, 8, 1))
    soft.write_nodal_velocity_to_sim(0.0)
    assert not soft.data.nodal_vel_w.any()
    for method, shape, wanted in (
        ("write_nodal_state_to_sim", (2, 8, 6), (3, 8, 6)),
        ("write_nodal_pos_to_sim", (3, 7, 3), (3, 8, 3)),
        ("write_nodal_velocity_to_sim", (3, 8, 2), (3, 8, 3)),
    ):
        with pytest.raises(
            ConfigError, match=re.escape(f"'object'.{method}: values of shape {shape} do not fit {wanted}")
        ):
            getattr(soft, method)(torch.zeros(shape))


CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]


def test_a_state_of_the_scene_is_taken_and_given_back():
    scene = start(soft_box())
    soft = scene["object"]
    state = scene.get_state(is_relative=True)
    assert sorted(state["deformable_object"]["object"]) == ["nodal_position", "nodal_velocity"]
    before = soft.data.nodal_state_w.clone()
    step(scene, 10)
    assert not torch.allclose(soft.data.nodal_state_w, before)
    scene.reset_to(state, is_relative=True)
    torch.testing.assert_close(soft.data.nodal_state_w, before, atol=1e-6, rtol=0)


def test_a_mass_is_written_to_some_environments_and_shared_by_the_nodes():
    scene = start(soft_box())
    soft, physics = scene["object"], scene.sim.physics
    torch.testing.assert_close(soft.data.default_mass, torch.full((3, 1), 0.3))
    soft.write_body_mass_to_sim(torch.tensor([[0.6], [0.1]]), env_ids=[0, 2])
    torch.testing.assert_close(soft.get_masses(), torch.tensor([[0.6], [0.3], [0.1]]))
    model = scene.sim.model
    for env_id, mass in enumerate((0.6, 0.3, 0.1)):
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, physics.get_data(env_id), inertia)
        # eight nodes that slide along three axes
        np.testing.assert_allclose(inertia, np.eye(24) * mass / 8, atol=1e-6)
    with pytest.raises(ConfigError, match="'object': masses must be positive, got 0"):
        soft.write_body_mass_to_sim(torch.zeros(3, 1))


def test_friction_is_written_to_some_environments_and_slows_a_slide():
    cfg = soft_box()
    cfg.init_state.pos = (0.0, 0.0, SIZE[2] / 2)
    scene = start(cfg, ground=True)
    soft = scene["object"]
    scene.sim.physics.randomizable("geom_friction")[..., 0] = 0.0  # the larger one of two counts
    soft.write_friction_to_sim(torch.full((3,), 0.1))
    soft.write_friction_to_sim(torch.tensor([[0.2], [0.3]]), env_ids=[1, 2])
    step(scene, 60)
    state = soft.data.nodal_state_w.clone()
    state[..., 3] = 1.5
    soft.write_nodal_state_to_sim(state)
    steps = 60
    step(scene, steps)
    friction = torch.tensor([0.1, 0.2, 0.3])
    torch.testing.assert_close(soft.data.root_vel_w[:, 0], 1.5 - friction * 9.81 * steps * DT, atol=0.04, rtol=0)


def test_what_it_has_not_is_named_with_what_is_near():
    soft = start(soft_box())["object"]
    with pytest.raises(
        UnknownAttributeError, match=r"^the data of 'object' \(DeformableObject\) have no 'root_quat_w'"
    ):
        _ = soft.data.root_quat_w
    with pytest.raises(AttributeError, match=r"^'object' \(DeformableObject\) has no 'write_nodal_pos'; did you mean"):
        _ = soft.write_nodal_pos
    assert not hasattr(soft, "write_joint_state_to_sim")


def test_nodes_are_turned_about_their_mean():
    soft = start(soft_box())["object"]
    nodes = soft.data.nodal_pos_w
    half = math.sqrt(0.5)
    turned = soft.transform_nodal_pos(
        nodes, torch.tensor([[0.1, 0.0, 0.0]] * 3), torch.tensor([[half, 0, 0, half]] * 3)
    )
    offset = nodes - nodes.mean(dim=1, keepdim=True)
    expected = torch.stack((-offset[..., 1], offset[..., 0], offset[..., 2]), dim=-1)
    shift = torch.tensor([0.1, 0.0, 0.0])
    torch.testing.assert_close(turned, nodes.mean(dim=1, keepdim=True) + expected + shift, atol=1e-6, rtol=0)


def test_it_comes_to_rest_on_the_ground_under_its_weight():
    cfg = soft_box()
    cfg.init_state.pos = (0.0, 0.0, 0.05)
    scene = start(cfg, ground=True)
    step(scene, 300)
    data = scene["object"].data
    height = data.root_pos_w[:, 2]
    # at most the contact's give and a sag of half of rho g h / E of the height
    assert ((height > 0.5 * SIZE[2] - 0.002) & (height < 0.5 * SIZE[2] + 1e-3)).all()
    assert data.nodal_vel_w.abs().max() < 0.01
    assert not scene.sim.physics.health().failed.any()


def test_the_shipped_file_is_a_deformable_cube_of_the_stated_numbers():
    spec, report = load(ASSETS_USD_DIR / "soft_cube.usda", strict=True)
    (body,) = report.soft_bodies
    assert body.size == pytest.approx((0.04, 0.04, 0.04))
    assert (body.mass, body.youngs_modulus, body.poissons_ratio) == pytest.approx((0.1, 5e4, 0.3))
    assert body.friction == pytest.approx((1.0, 0.02, 0.0001))
    assert (body.condim, body.solref) == (4, (0.01, 1.0))
    assert len(list(spec.bodies)) == 1
    assert not list(spec.geoms)


def author(path: Path, points, meters=1.0) -> str:
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, meters)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Soft").GetPrim())
    mesh = UsdGeom.Mesh.Define(stage, "/Soft/mesh")
    mesh.CreatePointsAttr(points)
    mesh.GetPrim().AddAppliedSchema("PhysxDeformableBodyAPI")
    stage.Save()
    return str(path)


def test_a_body_that_is_no_box_becomes_the_box_around_it_and_the_report_says_so(tmp_path):
    path = author(
        tmp_path / "octahedron.usda", [(2, 0, 0), (-2, 0, 0), (0, 2, 0), (0, -2, 0), (0, 0, 4), (0, 0, 0)], 0.01
    )
    _, report = load(path)
    (body,) = report.soft_bodies
    assert body.size == pytest.approx((0.04, 0.04, 0.04))
    assert body.position == pytest.approx((0.0, 0.0, 0.02))
    assert body.mass == pytest.approx(1000 * 0.04**3)  # of water's density
    assert [note.attribute for note in report.approximated] == ["points"]


def test_a_body_without_volume_is_refused_by_its_path(tmp_path):
    path = author(tmp_path / "sheet.usda", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)])
    with pytest.raises(UsdImportError, match=r"</Soft/mesh>.points: a deformable body has no volume"):
        load(path)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: (soft_box(), "implicitfast"),
            r"scene.object is deformable: set sim.mujoco.integrator='discrete' \(it is 'implicitfast'\)",
        ),
        (
            lambda: (
                soft_box(deformable_props=sim_utils.DeformableBodyPropertiesCfg(kinematic_enabled=True)),
                "discrete",
            ),
            "neither kinematic nor switched off",
        ),
        (
            lambda: (soft_box(rigid_props=sim_utils.RigidBodyPropertiesCfg()), "discrete"),
            "spawn.rigid_props and spawn.deformable_props exclude each other",
        ),
        (
            lambda: (soft_box(physics_material=sim_utils.RigidBodyMaterialCfg()), "discrete"),
            "takes a DeformableBodyMaterialCfg, not a RigidBodyMaterialCfg",
        ),
        (
            lambda: (soft_box(deformable_props=None, physics_material=None), "discrete"),
            r"exactly one deformable body, .* has: none \(set spawn.deformable_props\)",
        ),
        (
            lambda: (RigidObjectCfg(prim_path="/World/S", spawn=soft_box().spawn), "discrete"),
            "'/World/S' is deformable; use DeformableObjectCfg for it",
        ),
    ],
)
def test_what_cannot_be_simulated_is_refused_in_one_line(make, message):
    cfg, integrator = make()
    with pytest.raises(ConfigError, match=message):
        start(cfg, integrator=integrator)


def test_the_warp_engine_refuses_soft_bodies():
    model = start(soft_box()).sim.model
    with pytest.raises(ConfigError, match="soft bodies are simulated by the native engine only"):
        make_physics(model, 1, "cpu", "warp")


def test_without_deformable_properties_a_mesh_cuboid_is_a_rigid_box():
    spawn = soft_box(
        deformable_props=None,
        physics_material=None,
        rigid_props=sim_utils.RigidBodyPropertiesCfg(),
        collision_props=sim_utils.CollisionPropertiesCfg(),
    ).spawn
    scene = start(RigidObjectCfg(prim_path="{ENV_REGEX_NS}/Box", spawn=spawn), integrator="implicitfast")
    model = scene.sim.model
    assert model.nflex == 0
    (geom,) = [g for g in range(model.ngeom) if model.geom_contype[g]]
    assert model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_BOX
    assert model.geom_size[geom] == pytest.approx([edge / 2 for edge in SIZE])


def test_simulation_options_of_its_file_do_not_hold_and_the_report_says_so(tmp_path):
    corners = [(x, y, z) for x in (0, 0.1) for y in (0, 0.1) for z in (0, 0.1)]
    path = author(tmp_path / "soft.usda", corners)
    stage = Usd.Stage.Open(path)
    UsdPhysics.Scene.Define(stage, "/Sponge/Scene").CreateGravityMagnitudeAttr(3.0)
    stage.Save()
    cfg = DeformableObjectCfg(prim_path="{ENV_REGEX_NS}/Sponge", spawn=sim_utils.UsdFileCfg(usd_path=path))
    scene = start(cfg)
    np.testing.assert_allclose(scene.sim.model.opt.gravity, [0, 0, -9.81])
    notes = {note.attribute: note.reason for note in scene["object"].spawned.report.ignored}
    assert "in a scene sim.gravity (0 0 -9.81) holds" in notes["physics:gravityMagnitude"]
