"""UsdFileCfg and the shape spawners: scale, variants and property overrides as Isaac Lab's, on compiled models."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics

import lift_lab.sim as sim_utils
from lift_lab.sim.schemas import apply_schemas
from lift_lab.utils.errors import ConfigError, LiftLabError


@pytest.fixture
def file(tmp_path):
    """Base and link on a driven hinge, a box of 0.2 m each, self-collision off, a variant set of heavier links."""
    stage = Usd.Stage.CreateNew(str(tmp_path / "pair.usda"))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, "Z")
    root = UsdGeom.Xform.Define(stage, "/Pair").GetPrim()
    stage.SetDefaultPrim(root)
    UsdPhysics.ArticulationRootAPI.Apply(root)
    root.CreateAttribute("physxArticulation:enabledSelfCollisions", _types().Bool).Set(False)
    for name, x in (("base", 0.0), ("link", 0.5), ("tip", 1.0)):
        body = UsdGeom.Xform.Define(stage, f"/Pair/{name}")
        body.AddTranslateOp().Set(Gf.Vec3d(x, 0, 0))
        UsdPhysics.RigidBodyAPI.Apply(body.GetPrim())
        mass = UsdPhysics.MassAPI.Apply(body.GetPrim())
        mass.CreateMassAttr(2.0)
        mass.CreateDiagonalInertiaAttr(Gf.Vec3f(0.02, 0.03, 0.04))
        box = UsdGeom.Cube.Define(stage, f"/Pair/{name}/box")
        box.CreateSizeAttr(0.2)
        UsdPhysics.CollisionAPI.Apply(box.GetPrim())
    for name, body0, body1 in (("hinge", "base", "link"), ("wrist", "link", "tip")):
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/Pair/{name}")
        joint.CreateBody0Rel().SetTargets([f"/Pair/{body0}"])
        joint.CreateBody1Rel().SetTargets([f"/Pair/{body1}"])
        joint.CreateLocalPos0Attr(Gf.Vec3f(0.5, 0, 0))
        drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
        drive.CreateStiffnessAttr(1.0)
    sets = root.GetVariantSets().AddVariantSet("Load")
    for variant, mass in (("light", 2.0), ("heavy", 5.0)):
        sets.AddVariant(variant)
        sets.SetVariantSelection(variant)
        with sets.GetVariantEditContext():
            UsdPhysics.MassAPI(stage.GetPrimAtPath("/Pair/link")).GetMassAttr().Set(mass)
    sets.SetVariantSelection("light")
    UsdPhysics.MassAPI(stage.GetPrimAtPath("/Pair/link")).GetMassAttr().Clear()
    stage.Save()
    return tmp_path / "pair.usda"


def _types():
    from pxr import Sdf

    return Sdf.ValueTypeNames


def _model(cfg) -> mujoco.MjModel:
    spec = cfg.func("/World/Thing", cfg).spec
    apply_schemas(spec, cfg, "scene.thing.spawn")
    return spec.compile()


def _apart(model) -> set[frozenset[str]]:
    pairs = ((int(s) >> 16, int(s) & 0xFFFF) for s in model.exclude_signature)
    return {frozenset((model.body(a).name, model.body(b).name)) for a, b in pairs}


def test_a_scale_scales_lengths_and_leaves_masses(file):
    model = _model(sim_utils.UsdFileCfg(usd_path=str(file), scale=(2.0, 2.0, 2.0)))
    np.testing.assert_allclose(model.geom("box").size, 0.2)
    np.testing.assert_allclose(model.body("link").pos, (1.0, 0, 0), atol=1e-6)
    assert model.body("base").mass[0] == pytest.approx(2.0)


def test_a_variant_is_selected_by_name(file):
    assert _model(sim_utils.UsdFileCfg(usd_path=str(file))).body("link").mass[0] == pytest.approx(2.0)
    heavy = sim_utils.UsdFileCfg(usd_path=str(file), variants={"Load": "heavy"})
    assert _model(heavy).body("link").mass[0] == pytest.approx(5.0)
    with pytest.raises(LiftLabError, match="did you mean 'heavy'"):
        _model(sim_utils.UsdFileCfg(usd_path=str(file), variants={"Load": "haevy"}))


def test_rigid_properties_reach_every_body(file):
    props = sim_utils.RigidBodyPropertiesCfg(disable_gravity=True)
    assert _model(sim_utils.UsdFileCfg(usd_path=str(file), rigid_props=props)).body_gravcomp.tolist() == [0, 1, 1, 1]


def test_a_mass_scales_the_inertia_and_a_density_fills_the_colliders(file):
    mass = sim_utils.UsdFileCfg(usd_path=str(file), mass_props=sim_utils.MassPropertiesCfg(mass=4.0))
    model = _model(mass)
    np.testing.assert_allclose(model.body_mass[1:], 4.0)
    np.testing.assert_allclose(np.sort(model.body("base").inertia), (0.04, 0.06, 0.08), rtol=1e-5)
    density = sim_utils.UsdFileCfg(usd_path=str(file), mass_props=sim_utils.MassPropertiesCfg(density=500.0))
    np.testing.assert_allclose(_model(density).body_mass[1:], 500.0 * 0.2**3, rtol=1e-6)
    with pytest.raises(ConfigError, match="positive"):
        _model(sim_utils.UsdFileCfg(usd_path=str(file), mass_props=sim_utils.MassPropertiesCfg(mass=-1.0)))


def test_collision_properties_reach_every_collider(file):
    off = sim_utils.UsdFileCfg(
        usd_path=str(file), collision_props=sim_utils.CollisionPropertiesCfg(collision_enabled=False)
    )
    assert not _model(off).geom_contype.any()
    rest = sim_utils.UsdFileCfg(usd_path=str(file), collision_props=sim_utils.CollisionPropertiesCfg(rest_offset=0.003))
    np.testing.assert_allclose(_model(rest).geom_margin, 0.003)


@pytest.mark.parametrize(("switch", "apart"), [(None, 3), (False, 3), (True, 2)])
def test_self_collision_can_be_switched_but_jointed_bodies_stay_apart(file, switch, apart):
    props = sim_utils.ArticulationRootPropertiesCfg(enabled_self_collisions=switch)
    pairs = _apart(_model(sim_utils.UsdFileCfg(usd_path=str(file), articulation_props=props)))
    assert len(pairs) == apart
    assert frozenset(("base", "link")) in pairs
    assert (frozenset(("base", "tip")) in pairs) == (switch is not True)


@pytest.mark.parametrize(("fix", "nv"), [(None, 8), (True, 2), (False, 8)])
def test_the_root_link_can_be_fixed_and_freed(file, fix, nv):
    props = sim_utils.ArticulationRootPropertiesCfg(fix_root_link=fix)
    assert _model(sim_utils.UsdFileCfg(usd_path=str(file), articulation_props=props)).nv == nv


def test_drive_properties_override_the_files(file):
    props = sim_utils.JointDrivePropertiesCfg(stiffness=30.0, damping=4.0, max_effort=9.0)
    model = _model(sim_utils.UsdFileCfg(usd_path=str(file), joint_drive_props=props))
    np.testing.assert_allclose(model.actuator_gainprm[:, 0], 30.0)
    np.testing.assert_allclose(model.actuator_biasprm[:, 1:3], [(-30.0, -4.0)] * 2)
    np.testing.assert_allclose(model.jnt_actfrcrange[1:], [(-9.0, 9.0)] * 2)


@pytest.mark.parametrize(
    ("authored", "kp", "kd"),
    [
        ({"damping": 10.0, "targetVelocity": 2.0}, 0.0, 40.0),
        ({"damping": 10.0, "targetVelocity": 2.0}, 300.0, 40.0),
        ({"stiffness": 100.0, "damping": 10.0, "targetVelocity": 2.0, "targetPosition": 0.5}, None, 40.0),
        ({"stiffness": 100.0, "damping": 10.0, "targetVelocity": 2.0, "targetPosition": 0.5}, 300.0, None),
    ],
)
def test_drive_properties_keep_the_law_of_the_drive(tmp_path, authored, kp, kd):
    """force = kp (q* - q) + kd (v* - v), whichever actuators carry it; a drive that had no kp had no q* either."""
    stage = Usd.Stage.CreateNew(str(tmp_path / "slide.usda"))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/Robot").GetPrim())
    UsdPhysics.RigidBodyAPI.Apply(UsdGeom.Cube.Define(stage, "/Robot/a").GetPrim())
    UsdPhysics.CollisionAPI.Apply(stage.GetPrimAtPath("/Robot/a"))
    joint = UsdPhysics.PrismaticJoint.Define(stage, "/Robot/slide")
    joint.CreateBody1Rel().SetTargets(["/Robot/a"])
    joint.CreateAxisAttr("X")
    drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "linear")
    for name, value in authored.items():
        getattr(drive, f"Create{name[0].upper()}{name[1:]}Attr")(value)
    stage.Save()
    props = sim_utils.JointDrivePropertiesCfg(stiffness=kp, damping=kd)
    cfg = sim_utils.UsdFileCfg(usd_path=str(tmp_path / "slide.usda"), joint_drive_props=props)
    spawned = cfg.func("/World/Robot", cfg)
    apply_schemas(spawned.spec, cfg, "robot")
    model = spawned.spec.compile()
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = 0.1, 0.3
    for name, value in spawned.report.initial_ctrl.items():
        if not (kp and "stiffness" not in authored):  # then the one actuator's target is a position: zero
            data.actuator(name).ctrl[0] = value
    mujoco.mj_forward(model, data)
    kp_new = authored.get("stiffness", 0.0) if kp is None else kp
    kd_new = authored["damping"] if kd is None else kd
    v_target = 0.0 if kp and "stiffness" not in authored else authored["targetVelocity"]
    expected = kp_new * (authored.get("targetPosition", 0.0) - 0.1) + kd_new * (v_target - 0.3)
    np.testing.assert_allclose(data.qfrc_actuator, expected, rtol=1e-6)


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        (sim_utils.CuboidCfg(size=(0.1, 0.2, 0.3)), 0.006),
        (sim_utils.SphereCfg(radius=0.1), 4 / 3 * np.pi * 1e-3),
        (sim_utils.CapsuleCfg(radius=0.1, height=0.3), np.pi * 1e-2 * 0.3 + 4 / 3 * np.pi * 1e-3),
        (sim_utils.CylinderCfg(radius=0.1, height=0.3), np.pi * 1e-2 * 0.3),
        (sim_utils.ConeCfg(radius=0.1, height=0.3), np.pi * 1e-2 * 0.3 / 3),
    ],
)
def test_shapes_go_through_the_importer_with_their_volume_and_friction(shape, volume):
    shape.rigid_props = sim_utils.RigidBodyPropertiesCfg()
    shape.collision_props = sim_utils.CollisionPropertiesCfg()
    shape.mass_props = sim_utils.MassPropertiesCfg(density=100.0)
    shape.physics_material = sim_utils.RigidBodyMaterialCfg(dynamic_friction=0.7)
    spawned = shape.func("/World/Thing", shape)
    model = spawned.spec.compile()
    assert spawned.report.bodies == ["Thing"]
    assert model.body("Thing").mass[0] == pytest.approx(100.0 * volume, rel=0.02)
    assert model.geom_friction[0, 0] == pytest.approx(0.7)
    assert model.joint("Thing").type[0] == mujoco.mjtJoint.mjJNT_FREE
