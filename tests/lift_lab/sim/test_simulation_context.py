"""Settings reach the compiled model, and wrong ones are named."""

import mujoco
import numpy as np
import pytest
import torch

import lift_lab.sim as sim_utils
from lift_lab.assets import AssetBaseCfg, RigidObjectCfg
from lift_lab.scene import InteractiveScene, InteractiveSceneCfg
from lift_lab.sim.ignored import note_ignored, pending_ignored, report_ignored
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError, PhysicsError


def _shape(cfg, pos=(0.0, 0.0, 1.0), rot=(1.0, 0.0, 0.0, 0.0)) -> RigidObjectCfg:
    return RigidObjectCfg(
        prim_path="{ENV_REGEX_NS}/Thing",
        spawn=cfg,
        init_state=RigidObjectCfg.InitialStateCfg(pos=pos, rot=rot),
    )


@configclass
class _OneThingCfg(InteractiveSceneCfg):
    thing: RigidObjectCfg | None = None
    ground: AssetBaseCfg | None = None


_BODY = {
    "rigid_props": sim_utils.RigidBodyPropertiesCfg(),
    "collision_props": sim_utils.CollisionPropertiesCfg(),
}


def _compile(sim_cfg: sim_utils.SimulationCfg | None = None, **entities) -> mujoco.MjModel:
    sim = sim_utils.SimulationContext(sim_cfg or sim_utils.SimulationCfg(device="cpu"))
    InteractiveScene(_OneThingCfg(num_envs=1, env_spacing=1.0, **entities))
    sim.reset()
    return sim.model


def test_options_reach_the_model():
    cfg = sim_utils.SimulationCfg(device="cpu", dt=0.004, gravity=(0.0, 1.0, -3.0))
    cfg.mujoco.integrator = "implicit"
    cfg.mujoco.cone = "elliptic"
    cfg.mujoco.iterations = 7
    cfg.mujoco.impratio = 5.0
    cfg.mujoco.island = False
    cfg.mujoco.warmstart = False
    option = _compile(cfg, thing=_shape(sim_utils.SphereCfg(radius=0.1, **_BODY))).opt
    assert option.timestep == 0.004
    np.testing.assert_allclose(option.gravity, [0, 1, -3])
    assert option.integrator == int(mujoco.mjtIntegrator.mjINT_IMPLICIT)
    assert option.cone == int(mujoco.mjtCone.mjCONE_ELLIPTIC)
    assert (option.iterations, option.impratio) == (7, 5.0)
    off = mujoco.mjtDisableBit.mjDSBL_ISLAND.value | mujoco.mjtDisableBit.mjDSBL_WARMSTART.value
    assert option.disableflags & off == off
    by_default = _compile(thing=_shape(sim_utils.SphereCfg(radius=0.1, **_BODY))).opt
    assert not by_default.disableflags & off


@pytest.mark.parametrize(
    ("cfg", "geom", "size"),
    [
        (sim_utils.SphereCfg(radius=0.1, **_BODY), mujoco.mjtGeom.mjGEOM_SPHERE, [0.1]),
        (sim_utils.CuboidCfg(size=(0.2, 0.4, 0.6), **_BODY), mujoco.mjtGeom.mjGEOM_BOX, [0.1, 0.2, 0.3]),
        (sim_utils.CapsuleCfg(radius=0.1, height=0.6, **_BODY), mujoco.mjtGeom.mjGEOM_CAPSULE, [0.1, 0.3]),
        (sim_utils.CylinderCfg(radius=0.1, height=0.6, **_BODY), mujoco.mjtGeom.mjGEOM_CYLINDER, [0.1, 0.3]),
    ],
)
def test_a_shape_becomes_its_geom(cfg, geom, size):
    model = _compile(thing=_shape(cfg))
    colliders = [g for g in range(model.ngeom) if model.geom_contype[g]]
    assert len(colliders) == 1
    assert model.geom_type[colliders[0]] == int(geom)
    np.testing.assert_allclose(model.geom_size[colliders[0]][: len(size)], size, rtol=1e-6)
    assert model.body(1).name == "thing/Thing"


def test_a_cone_becomes_its_convex_mesh():
    model = _compile(thing=_shape(sim_utils.ConeCfg(radius=0.3, height=0.9, **_BODY)))
    collider = next(g for g in range(model.ngeom) if model.geom_contype[g])
    assert model.geom_type[collider] == int(mujoco.mjtGeom.mjGEOM_MESH)
    # a cone of density 1000: pi r^2 h / 3, a little less for its flat sides
    assert model.body_mass[1] == pytest.approx(1000 * np.pi * 0.3**2 * 0.9 / 3, rel=0.03)


def test_mass_and_density_overrides():
    by_mass = sim_utils.CuboidCfg(size=(0.1, 0.1, 0.1), mass_props=sim_utils.MassPropertiesCfg(mass=0.7), **_BODY)
    assert _compile(thing=_shape(by_mass)).body_mass[1] == pytest.approx(0.7)
    by_density = sim_utils.CuboidCfg(size=(0.1, 0.1, 0.1), mass_props=sim_utils.MassPropertiesCfg(density=400), **_BODY)
    assert _compile(thing=_shape(by_density)).body_mass[1] == pytest.approx(0.4, rel=1e-5)


def test_the_ground_plane_stands_where_it_is_put():
    ground = AssetBaseCfg(
        prim_path="/World/ground",
        spawn=sim_utils.GroundPlaneCfg(),
        init_state=AssetBaseCfg.InitialStateCfg(pos=(0.0, 0.0, -1.05)),
    )
    model = _compile(ground=ground)
    assert model.geom_type[0] == int(mujoco.mjtGeom.mjGEOM_PLANE)
    assert model.geom_pos[0][2] == pytest.approx(-1.05)


def test_an_orientation_is_normalised():
    model = _compile(thing=_shape(sim_utils.SphereCfg(radius=0.1, **_BODY), rot=(0.707, 0.0, 0.0, 0.707)))
    np.testing.assert_allclose(model.qpos0[3:7], [0.5**0.5, 0, 0, 0.5**0.5], rtol=1e-12)


def test_a_zero_orientation_is_refused():
    with pytest.raises(ConfigError, match=r"scene.thing.init_state.rot .* is not an orientation"):
        _compile(thing=_shape(sim_utils.SphereCfg(radius=0.1, **_BODY), rot=(0.0, 0.0, 0.0, 0.0)))


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("integrator", "euler", "sim.mujoco.integrator: 'euler' is not one of Euler, RK4"),
        ("cone", "round", "sim.mujoco.cone: 'round'"),
        ("solver", "Gauss", "sim.mujoco.solver: 'Gauss'"),
    ],
)
def test_an_unknown_solver_option_is_named(field, value, message):
    cfg = sim_utils.SimulationCfg(device="cpu")
    setattr(cfg.mujoco, field, value)
    with pytest.raises(ConfigError, match=message):
        _compile(cfg, thing=_shape(sim_utils.SphereCfg(radius=0.1, **_BODY)))


def test_a_missing_gpu_is_named():
    with pytest.raises(ConfigError, match=r"device 'cuda:63' is not available; choose one of: cpu"):
        sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cuda:63"))


def test_using_the_engine_before_reset_is_refused():
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu"))
    with pytest.raises(PhysicsError, match=r"call sim\.reset"):
        _ = sim.physics


def test_a_camera_in_a_scene_is_refused():
    cfg = AssetBaseCfg(prim_path="/World/camera", spawn=sim_utils.PinholeCameraCfg())
    with pytest.raises(ConfigError, match="/World/camera: camera sensors are not supported"):
        _compile(ground=cfg)


def test_an_ignored_setting_is_reported_once():
    report_ignored()
    note_ignored("scene.x.test_setting", "no counterpart")
    assert pending_ignored() == {"scene.x.test_setting": "no counterpart"}
    assert "scene.x.test_setting" in (report_ignored() or "")
    note_ignored("scene.x.test_setting", "no counterpart")
    assert report_ignored() is None


def test_physx_values_that_differ_from_their_defaults_are_ignored_aloud():
    cfg = sim_utils.SimulationCfg(device="cpu")
    cfg.physx.bounce_threshold_velocity = 0.123
    sim_utils.SimulationContext(cfg)
    assert "sim.physx.bounce_threshold_velocity" in pending_ignored()


def test_materials_that_have_no_effect_are_reported():
    report_ignored()
    sim = sim_utils.SimulationContext(
        sim_utils.SimulationCfg(device="cpu", physics_material=sim_utils.RigidBodyMaterialCfg(dynamic_friction=1.5))
    )
    material = sim_utils.RigidBodyMaterialCfg(restitution=0.9, friction_combine_mode="multiply")
    for cfg in (
        sim_utils.SphereCfg(radius=0.1, collision_props=sim_utils.CollisionPropertiesCfg()),
        sim_utils.GroundPlaneCfg(),
    ):
        cfg.physics_material = material
        cfg.func(f"/World/{type(cfg).__name__}", cfg)
    noted = pending_ignored()
    assert "sim.physics_material" in noted
    for kind in ("SphereCfg", "GroundPlaneCfg"):
        for name in ("restitution", "friction_combine_mode"):
            assert f"spawn of /World/{kind}: physics_material.{name}" in noted
    sim.close()
    report_ignored()


def test_a_device_flag_that_was_left_out_chooses_as_auto_does():
    assert sim_utils.SimulationContext(sim_utils.SimulationCfg(device=None)).device == (
        "cuda:0" if torch.cuda.is_available() else "cpu"
    )


def test_the_camera_of_a_script_stands_where_it_was_put():
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu"))
    eye, target = np.array([2.0, -1.5, 1.2]), np.array([0.5, 0.25, 0.2])
    sim.set_camera_view(eye.tolist(), target.tolist())
    azimuth, elevation = np.radians(sim._view.azimuth_deg), np.radians(sim._view.elevation_deg)
    ahead = [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    np.testing.assert_allclose(np.array(sim._view.lookat) - sim._view.distance * np.array(ahead), eye, atol=1e-9)
    with pytest.raises(ConfigError, match="same point"):
        sim.set_camera_view(target, target)


def test_questions_that_scripts_ask_of_isaac_sim_are_answered():
    sim = sim_utils.SimulationContext(sim_utils.SimulationCfg(device="cpu"))
    assert (sim.is_playing(), sim.is_stopped()) == (False, True)
    InteractiveScene(_OneThingCfg(num_envs=1, env_spacing=1.0, thing=_shape(sim_utils.SphereCfg(radius=0.1, **_BODY))))
    sim.reset()
    assert (sim.is_playing(), sim.is_stopped()) == (True, False)
    assert not sim.has_gui()
    assert not sim.has_rtx_sensors()
