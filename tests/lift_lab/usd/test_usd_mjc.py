"""MjcPhysics prims against the MJCF they stand for."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from pxr import UsdPhysics

from lift_lab.sim import SimulationCfg, SimulationContext
from lift_lab.usd import UsdImportError, load


@pytest.fixture
def arm(author):
    """Two hinges in a row with a site on each link."""
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/upper", com=(0, 0, 0.2))
    a.body("/Robot/lower", pos=(0, 0, 0.5), com=(0, 0, 0.2))
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/base")
    a.joint("/Robot/j1", "RevoluteJoint", "/Robot/base", "/Robot/upper", "X")
    a.joint("/Robot/j2", "RevoluteJoint", "/Robot/upper", "/Robot/lower", "X", pos0=(0, 0, 0.5))
    for name, pos in (("upper", (0, 0.1, 0.3)), ("lower", (0, 0.1, 0.2))):
        a.set(a.gprim(f"/Robot/{name}/{name}_site", "Sphere", collider=False, pos=pos, radius=0.01), "MjcSiteAPI")
    return a


def _prim(a, path, kind, relations=None, **attrs):
    prim = a.stage.DefinePrim(path, kind)
    a.attrs(prim, {f"mjc:{name.replace('__', ':')}": value for name, value in attrs.items()})
    for name, targets in (relations or {}).items():
        prim.CreateRelationship(f"mjc:{name}").SetTargets(targets)
    return prim


def test_a_joint_actuator_is_mjcfs_general_actuator(arm):
    _prim(
        arm, "/Robot/motor", "MjcActuator", {"target": ["/Robot/j1"]},
        gainType="fixed", gainPrm=[20.0], biasType="affine", biasPrm=[0.0, -20.0, -2.0], gear=[3.0],
        dynType="filter", dynPrm=[0.05], ctrlRange__min=-1.0, ctrlRange__max=2.0, forceRange__min=-5.0,
        forceRange__max=6.0, ctrlLimited="true", group=2,
    )  # fmt: skip
    model, report = arm.load()
    twin = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody><body><joint name="j" type="slide"/><geom size=".1"/></body></worldbody><actuator>
        <general joint="j" gaintype="fixed" gainprm="20" biastype="affine" biasprm="0 -20 -2" gear="3" dyntype="filter"
        dynprm=".05" ctrlrange="-1 2" forcerange="-5 6" group="2"/></actuator></mujoco>"""
    )
    assert report.actuators == ["motor"]
    for field in ("gainprm", "biasprm", "dynprm", "gear", "ctrlrange", "forcerange", "ctrllimited", "forcelimited",
                  "gaintype", "biastype", "dyntype", "trntype", "group"):  # fmt: skip
        np.testing.assert_allclose(getattr(model, f"actuator_{field}"), getattr(twin, f"actuator_{field}"))
    assert model.actuator_trnid[0, 0] == model.joint("j1").id


def test_a_site_actuator_pushes_along_its_gear(arm):
    _prim(
        arm, "/Robot/thruster", "MjcActuator", {"target": ["/Robot/lower/lower_site"]},
        gear=[0.0, 0.0, 10.0, 0.0, 0.0, 2.0],
    )  # fmt: skip
    model, _ = arm.load()
    assert model.actuator_trntype[0] == mujoco.mjtTrn.mjTRN_SITE
    np.testing.assert_allclose(model.actuator_gear[0], (0, 0, 10, 0, 0, 2))


def test_an_actuator_without_a_known_target_is_an_error(arm):
    _prim(arm, "/Robot/motor", "MjcActuator", {"target": ["/Robot/base"]}, gear=[1.0])
    arm.load()  # a body is a legal target
    _prim(arm, "/Robot/other", "MjcActuator", {"target": ["/Robot"]})
    with pytest.raises(UsdImportError, match=r"</Robot/other>\.mjc:target"):
        arm.load()


def test_an_actuator_without_target_is_left_out_and_reported(arm, notes):
    _prim(arm, "/Robot/motor", "MjcActuator", gear=[1.0])
    model, report = arm.load()
    assert model.nu == 0
    assert notes(report, "/Robot/motor")[0] == ["an actuator without a target"]


def test_an_unknown_token_lists_the_known_ones(arm):
    _prim(arm, "/Robot/motor", "MjcActuator", {"target": ["/Robot/j1"]}, gainType="magic")
    with pytest.raises(UsdImportError, match="'magic' is none of fixed, affine"):
        arm.load()


def test_an_actuator_of_two_joints_drives_the_first_and_says_so(arm, notes):
    _prim(arm, "/Robot/motor", "MjcActuator", {"target": ["/Robot/j2", "/Robot/j1"]})
    model, report = arm.load()
    assert model.actuator_trnid[:, 0].tolist() == [model.joint("j2").id]
    assert notes(report, "/Robot/motor")[0] == ["an actuator drives its first target only"]


@pytest.mark.parametrize("key", ["ctrlRange", "forceRange"])
def test_a_range_the_wrong_way_round_is_an_error(arm, key):
    ends = {f"{key}__min": 5.0, f"{key}__max": -5.0}
    _prim(arm, "/Robot/motor", "MjcActuator", {"target": ["/Robot/j1"]}, **ends)
    with pytest.raises(UsdImportError, match=rf"</Robot/motor>\.mjc:{key}:min: must not be above .*5 > -5"):
        arm.load()


def test_a_fixed_tendon_is_a_weighted_sum_of_joints(arm):
    _prim(
        arm, "/Robot/t", "MjcTendon", {"path": ["/Robot/j1", "/Robot/j2"]}, type="fixed", path__coef=[2.0, -3.0],
        stiffness=4.0, damping=0.5, range__min=-1.0, range__max=1.5, limited="true",
    )  # fmt: skip
    _prim(arm, "/Robot/pull", "MjcActuator", {"target": ["/Robot/t"]}, gear=[1.0])
    model, _ = arm.load()
    data = mujoco.MjData(model)
    data.qpos[:] = (0.3, 0.7)
    mujoco.mj_forward(model, data)
    assert data.ten_length[0] == pytest.approx(2 * 0.3 - 3 * 0.7)
    assert model.tendon_stiffness[0] == pytest.approx(4.0)
    assert model.tendon_damping[0] == pytest.approx(0.5)
    np.testing.assert_allclose(model.tendon_range[0], (-1, 1.5))
    assert model.actuator_trntype[0] == mujoco.mjtTrn.mjTRN_TENDON


def test_a_spatial_tendon_runs_through_its_sites_in_order(arm):
    _prim(
        arm, "/Robot/t", "MjcTendon", {"path": ["/Robot/lower/lower_site", "/Robot/upper/upper_site"]},
        path__indices=[1, 0], springlength=[0.25], width=0.004,
    )  # fmt: skip
    model, _ = arm.load()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ten_length[0] == pytest.approx(0.4)
    np.testing.assert_allclose(model.tendon_lengthspring[0], (0.25, 0.25))
    assert model.wrap_objid[0] == model.site("upper_site").id


def test_a_spatial_tendon_wraps_geoms_beside_their_side_sites(arm):
    arm.gprim("/Robot/upper/pulley", "Cylinder", pos=(0, 0, 0.5), radius=0.05, height=0.1, axis="X")
    side = arm.gprim("/Robot/upper/side", "Sphere", collider=False, pos=(0, 0.1, 0.5), radius=0.01)
    arm.set(side, "MjcSiteAPI")
    _prim(
        arm, "/Robot/t", "MjcTendon",
        {"path": ["/Robot/upper/upper_site", "/Robot/upper/pulley", "/Robot/lower/lower_site"],
         "sideSites": ["/Robot/upper/side"]},
        sideSites__indices=[-1, 0, -1],
    )  # fmt: skip
    model, _ = arm.load()
    assert model.wrap_type.tolist() == [int(t) for t in (
        mujoco.mjtWrap.mjWRAP_SITE, mujoco.mjtWrap.mjWRAP_CYLINDER, mujoco.mjtWrap.mjWRAP_SITE)]  # fmt: skip
    assert model.wrap_prm[1] == model.site("side").id


def test_keyframes_are_kept_and_misfits_reported(arm, notes):
    _prim(arm, "/Robot/home", "MjcKeyframe", qpos=[0.1, 0.2], qvel=[0.3, 0.4])
    _prim(arm, "/Robot/bad", "MjcKeyframe", qpos=[0.1])
    model, report = arm.load()
    assert model.nkey == 1
    np.testing.assert_allclose(model.key("home").qpos, (0.1, 0.2))
    np.testing.assert_allclose(model.key("home").qvel, (0.3, 0.4))
    assert notes(report, "/Robot/bad")[0] == ["1 values where the model has 2"]


def test_options_that_the_stage_does_not_set_are_those_of_scenes(arm):
    """All that a scene's default settings write into a spec, but the time step and gravity, which are a task's."""
    expected = mujoco.MjSpec()
    SimulationContext(SimulationCfg(device="cpu")).configure(expected)
    spec, report = load(arm.stage)
    names = [name for name in dir(expected.option) if not name.startswith("_") and name not in ("timestep", "gravity")]
    for name in names:
        np.testing.assert_array_equal(getattr(spec.option, name), getattr(expected.option, name), err_msg=name)
    assert spec.option.timestep == 0.002
    assert report.assumed_options == {"integrator": "implicitfast", "iterations": "10", "ls_iterations": "20"}


def test_options_that_the_stage_sets_stay(arm):
    scene = UsdPhysics.Scene.Define(arm.stage, "/Scene").GetPrim()
    arm.attrs(scene, {"mjc:option:integrator": "euler", "mjc:option:iterations": 100}, "MjcSceneAPI")
    model, report = arm.load()
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER
    assert (model.opt.iterations, model.opt.ls_iterations) == (100, 20)
    assert report.assumed_options == {"ls_iterations": "20"}


def test_a_drive_of_usual_damping_is_stable_as_loaded(author):
    """Euler multiplies the speed by 1 - dt d / I = -19 a step, implicitfast by 1 / (1 + 20)."""
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link", inertia=(0.01, 0.01, 0.01))
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/base")
    hinge = a.joint("/Robot/hinge", "RevoluteJoint", "/Robot/base", "/Robot/link", "X")
    a.drive(hinge, damping=math.radians(100.0))
    model, _ = a.load()
    model.opt.gravity = 0
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    ends = []
    for integrator in (model.opt.integrator, mujoco.mjtIntegrator.mjINT_EULER):
        model.opt.integrator = integrator
        data = mujoco.MjData(model)
        data.qvel = 1.0
        mujoco.mj_step(model, data, 10)
        ends.append(float(np.abs(data.qvel).max()))
    assert ends[0] == pytest.approx(21.0**-10, rel=1e-3)
    assert ends[1] == pytest.approx(19.0**10, rel=1e-3)


def test_scene_options_and_flags_are_mjcfs(arm):
    scene = UsdPhysics.Scene.Define(arm.stage, "/scene").GetPrim()
    arm.attrs(
        scene,
        {
            "mjc:option:timestep": 0.004, "mjc:option:integrator": "implicitfast", "mjc:option:cone": "elliptic",
            "mjc:option:solver": "cg", "mjc:option:iterations": 17, "mjc:option:impratio": 5.0,
            "mjc:flag:contact": False, "mjc:flag:energy": True, "mjc:flag:warmstart": True,
        },
        "MjcSceneAPI",
    )  # fmt: skip
    option = arm.load()[0].opt
    assert (option.timestep, option.iterations, option.impratio) == pytest.approx((0.004, 17, 5.0))
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert option.solver == mujoco.mjtSolver.mjSOL_CG
    assert option.disableflags == mujoco.mjtDisableBit.mjDSBL_CONTACT
    assert option.enableflags & mujoco.mjtEnableBit.mjENBL_ENERGY


@pytest.mark.parametrize(
    ("attribute", "value", "told"),
    [
        ("mjc:option:timestep", -0.002, "must be above zero, is -0.002"),
        ("mjc:option:timestep", 0.0, "must be above zero"),
        ("mjc:option:impratio", 0.0, "must be above zero"),
        ("mjc:option:iterations", -1, "must not be negative, is -1"),
        ("mjc:option:tolerance", -1e-8, "must not be negative"),
        ("newton:timeStepsPerSecond", -100, "must not be negative, is -100"),
    ],
)
def test_an_option_out_of_range_is_an_error(arm, attribute, value, told):
    arm.attrs(UsdPhysics.Scene.Define(arm.stage, "/scene").GetPrim(), {attribute: value}, "MjcSceneAPI")
    with pytest.raises(UsdImportError, match=rf"</scene>\..*{told}"):
        arm.load()


def test_options_may_be_zero_or_negative_where_that_means_something(arm):
    values = {"mjc:option:o_margin": -0.01, "mjc:option:tolerance": 0.0, "mjc:option:wind": [-1.0, 0.0, 0.0]}
    arm.attrs(UsdPhysics.Scene.Define(arm.stage, "/scene").GetPrim(), values, "MjcSceneAPI")
    option = arm.load()[0].opt
    assert (option.o_margin, option.tolerance, option.wind[0]) == pytest.approx((-0.01, 0.0, -1.0))


@pytest.mark.parametrize("attribute", ["mjc:flag:gravity", "newton:gravityEnabled"])
def test_gravity_can_be_switched_off_for_the_scene(arm, attribute):
    arm.attrs(UsdPhysics.Scene.Define(arm.stage, "/scene").GetPrim(), {attribute: False})
    np.testing.assert_allclose(arm.load()[0].opt.gravity, 0)


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ({"newton:timeStepsPerSecond": 250}, 0.004),
        ({"physxScene:timeStepsPerSecond": 100}, 0.01),
        ({"newton:timeStepsPerSecond": 250, "mjc:option:timestep": 0.003}, 0.003),
    ],
)
def test_the_time_step_comes_from_any_dialect(arm, values, expected):
    arm.attrs(UsdPhysics.Scene.Define(arm.stage, "/scene").GetPrim(), values)
    assert arm.load()[0].opt.timestep == pytest.approx(expected)


def test_a_total_mass_scales_every_body(arm):
    arm.attrs(UsdPhysics.Scene.Define(arm.stage, "/scene").GetPrim(), {"mjc:compiler:setTotalMass": 6.0})
    model, _ = arm.load()
    np.testing.assert_allclose(model.body_mass[1:], 2.0, rtol=1e-6)
    np.testing.assert_allclose(model.body_inertia[1:], 0.02, rtol=1e-6)
