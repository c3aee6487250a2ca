"""Joint types, limits and passive terms of every dialect."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from pxr import Gf, Sdf, UsdPhysics
from scipy.spatial.transform import Rotation

from lift_lab.usd import UsdImportError

DEG = math.pi / 180
HINGE, SLIDE, BALL = (
    int(t) for t in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_BALL)
)


@pytest.fixture
def pair(author):
    """A base welded to the world and a free link beside it."""
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link", pos=(0, 0, 1))
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    return a


def _limit(prim, token, low, high):
    api = UsdPhysics.LimitAPI.Apply(prim, token)
    api.CreateLowAttr(low)
    api.CreateHighAttr(high)


def test_revolute_limits_are_degrees_and_prismatic_limits_lengths(pair):
    pair.body("/Robot/tip")
    pair.joint("/Robot/r", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", limits=(-90, 45))
    pair.joint("/Robot/p", "PrismaticJoint", "/Robot/link", "/Robot/tip", "X", limits=(-0.25, 0.5))
    model, _ = pair.load()
    np.testing.assert_allclose(model.jnt_range, [(-math.pi / 2, math.pi / 4), (-0.25, 0.5)], rtol=1e-6)
    assert model.jnt_limited.tolist() == [1, 1]
    assert model.jnt_type.tolist() == [HINGE, SLIDE]


@pytest.mark.parametrize("limits", [None, (-math.inf, math.inf), (-1e30, 1e30), (-3.4e38, 3.4e38)])
def test_infinite_limits_leave_the_joint_unlimited(pair, limits):
    pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", limits=limits)
    assert pair.load()[0].jnt_limited[0] == 0


def test_a_one_sided_limit_keeps_its_finite_side(pair):
    pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", limits=(-math.inf, 30))
    model, _ = pair.load()
    assert model.jnt_limited[0] == 1
    assert model.jnt_range[0, 1] == pytest.approx(30 * DEG)
    assert model.jnt_range[0, 0] < -1e5


def test_limits_that_coincide_hold_the_joint_in_a_narrow_range(pair, notes):
    pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", limits=(90, 90))
    model, report = pair.load()
    np.testing.assert_allclose(model.jnt_range[0], math.pi / 2, atol=2e-6)
    assert "coincide" in notes(report, "/Robot/j")[1][0]


@pytest.mark.parametrize(("axis", "expected"), [("X", (1, 0, 0)), ("Y", (0, 1, 0)), ("Z", (0, 0, 1))])
def test_the_axis_token_is_read_in_the_joint_frame(pair, axis, expected):
    rot = Rotation.from_euler("zyx", (10, 20, 30), degrees=True)
    pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", axis, rot1=np.roll(rot.as_quat(), 1))
    np.testing.assert_allclose(pair.load()[0].jnt_axis[0], rot.apply(expected), atol=1e-6)


def test_a_d6_joint_locks_where_low_is_above_high_and_is_free_without_limit(pair):
    """transX limited, transY free, transZ locked, rotX locked, rotY limited, rotZ locked."""
    joint = pair.joint("/Robot/d", "Joint", "/Robot/base", "/Robot/link", pos0=(0, 0, 1))
    _limit(joint, "transX", -0.1, 0.2)
    _limit(joint, "transZ", 1.0, -1.0)
    _limit(joint, "rotX", 1.0, -1.0)
    _limit(joint, "rotY", -20.0, 10.0)
    _limit(joint, "rotZ", 1.0, -1.0)
    model, report = pair.load()
    assert report.joints == ["d_transX", "d_transY", "d_rotY"]
    assert model.jnt_type.tolist() == [SLIDE, SLIDE, HINGE]
    assert model.jnt_limited.tolist() == [1, 0, 1]
    np.testing.assert_allclose(model.jnt_range[[0, 2]], [(-0.1, 0.2), (-20 * DEG, 10 * DEG)], rtol=1e-6)
    np.testing.assert_allclose(model.jnt_axis, [(1, 0, 0), (0, 1, 0), (0, 1, 0)])
    # slides come before the hinge: the link moves along the base's axes whatever its angle
    data = mujoco.MjData(model)
    data.qpos[:] = (0.1, 0.3, 0.5)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.body("link").xpos, (0.1, 0.3, 1), atol=1e-9)


def test_a_d6_axis_held_at_zero_is_locked_with_or_without_its_api(pair, notes):
    """Exporters write limits without applying LimitAPI; a range of nothing at zero is a lock."""
    joint = pair.joint("/Robot/d", "Joint", "/Robot/base", "/Robot/link", pos0=(0, 0, 1))
    _limit(joint, "transX", 0.0, 0.0)
    for token in ("transY", "transZ", "rotY", "rotZ"):
        pair.attrs(joint, {f"limit:{token}:physics:low": 0.0, f"limit:{token}:physics:high": 0.0})
    pair.attrs(joint, {"limit:rotX:physics:low": -90.0, "limit:rotX:physics:high": 45.0})
    model, report = pair.load()
    assert report.joints == ["d"]
    np.testing.assert_allclose(model.jnt_range[0], [-math.pi / 2, math.pi / 4], rtol=1e-6)
    assert sum("not applied" in reason for reason in notes(report, "/Robot/d")[1]) == 5


def test_a_reversed_d6_joint_is_the_inverse_chain(author):
    """Authored from the link to the base: base = link * F0 * X(x) * RX(a) * RZ(b) * F1^-1."""
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link", pos=(0, 0, -0.2))
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    joint = a.joint("/Robot/d", "Joint", "/Robot/link", "/Robot/base", pos0=(0.1, 0, 0.2), pos1=(0, 0.3, 0))
    for token in ("transY", "transZ", "rotY"):
        _limit(joint, token, 1.0, -1.0)
    for token in ("rotX", "rotZ"):
        _limit(joint, token, -60.0, 60.0)
    model, report = a.load()
    data = mujoco.MjData(model)
    q = {"d_transX": 0.3, "d_rotX": 0.5, "d_rotZ": -0.8}
    assert report.joints == ["d_rotZ", "d_rotX", "d_transX"]
    for name, value in q.items():
        data.joint(name).qpos[0] = value
    mujoco.mj_kinematics(model, data)
    turn = Rotation.from_euler("x", 0.5) * Rotation.from_euler("z", -0.8)
    # link to base: p -> F0 X R F1^-1 p
    base_in_link = np.array([0.1 + 0.3, 0, 0.2]) + turn.apply([0, -0.3, 0])
    np.testing.assert_allclose(data.body("link").xpos, -turn.inv().apply(base_in_link), atol=1e-6)
    np.testing.assert_allclose(data.body("link").xmat.reshape(3, 3), turn.inv().as_matrix(), atol=1e-6)


def test_a_d6_joint_with_one_free_axis_is_that_joint_under_its_own_name(pair):
    joint = pair.joint("/Robot/d", "Joint", "/Robot/base", "/Robot/link")
    for token in ("transX", "transY", "transZ", "rotX", "rotY"):
        _limit(joint, token, 1.0, -1.0)
    model, report = pair.load()
    assert report.joints == ["d"]
    assert model.jnt_type.tolist() == [HINGE]
    np.testing.assert_allclose(model.jnt_axis[0], (0, 0, 1))


def test_a_d6_joint_that_locks_everything_welds(pair):
    joint = pair.joint("/Robot/d", "Joint", "/Robot/base", "/Robot/link", pos0=(0, 0, 1))
    for token in ("transX", "transY", "transZ", "rotX", "rotY", "rotZ"):
        _limit(joint, token, 1.0, -1.0)
    model, _ = pair.load()
    assert model.nv == 0
    assert model.body_parentid[model.body("link").id] == model.body("base").id


def test_a_d6_joint_free_to_turn_is_a_ball_and_keeps_its_slides(pair):
    joint = pair.joint("/Robot/d", "Joint", "/Robot/base", "/Robot/link")
    for token in ("transX", "transY"):
        _limit(joint, token, 1.0, -1.0)
    model, report = pair.load()
    assert model.jnt_type.tolist() == [SLIDE, BALL]
    assert report.joints == ["d_transZ", "d_rot"]


def test_d6_drives_act_on_their_own_axis(pair):
    joint = pair.joint("/Robot/d", "Joint", "/Robot/base", "/Robot/link")
    for token in ("transX", "transY", "transZ", "rotX"):
        _limit(joint, token, 1.0, -1.0)
    pair.drive(joint, "rotY", stiffness=2.0, damping=0.5)
    model, report = pair.load()
    assert report.actuators == ["d_rotY"]
    assert model.actuator_trnid[0, 0] == model.joint("d_rotY").id
    assert model.actuator_gainprm[0, 0] == pytest.approx(2.0 / DEG)


def test_a_spherical_joint_is_a_ball_whose_range_is_the_smaller_cone(pair, notes):
    pair.joint("/Robot/s", "SphericalJoint", "/Robot/base", "/Robot/link", pos0=(0, 0, 0.5), pos1=(0, 0, -0.5),
               **{"physics:coneAngle0Limit": 40.0, "physics:coneAngle1Limit": 25.0})  # fmt: skip
    model, report = pair.load()
    assert model.jnt_type.tolist() == [BALL]
    np.testing.assert_allclose(model.jnt_range[0], (0, 25 * DEG), rtol=1e-6)
    np.testing.assert_allclose(model.jnt_pos[0], (0, 0, -0.5))
    assert "smaller cone" in notes(report, "/Robot/s")[1][0]


def test_a_spherical_joint_without_cone_is_unlimited(pair):
    pair.joint("/Robot/s", "SphericalJoint", "/Robot/base", "/Robot/link")
    assert pair.load()[0].jnt_limited[0] == 0


def test_several_joints_between_two_bodies_add_up_on_one_body(pair):
    """As MJCF: two hinges and a slide of one body, in their authored order."""
    pair.joint("/Robot/a", "PrismaticJoint", "/Robot/base", "/Robot/link", "X", pos0=(0, 0, 1))
    pair.joint("/Robot/b", "RevoluteJoint", "/Robot/base", "/Robot/link", "Y", pos0=(0, 0, 1.5), pos1=(0, 0, 0.5))
    pair.joint("/Robot/c", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", pos0=(0, 0, 1))
    model, report = pair.load()
    twin = mujoco.MjModel.from_xml_string(
        """<mujoco><compiler angle="radian"/><worldbody><body><inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/>
        <body name="link" pos="0 0 1"><inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/>
        <joint type="slide" axis="1 0 0"/><joint axis="0 1 0" pos="0 0 .5"/><joint axis="0 0 1"/>
        </body></body></worldbody></mujoco>"""
    )
    assert report.joints == ["a", "b", "c"]
    states = []
    for m in (model, twin):
        data = mujoco.MjData(m)
        data.qpos[:] = (0.2, 0.7, -0.4)
        mujoco.mj_forward(m, data)
        states.append((data.body("link").xpos.copy(), data.body("link").xquat.copy()))
    np.testing.assert_allclose(states[0][0], states[1][0], atol=1e-9)
    np.testing.assert_allclose(states[0][1], states[1][1], atol=1e-9)


def test_a_ball_and_a_slide_between_two_bodies_add_up(pair):
    pair.joint("/Robot/slide", "PrismaticJoint", "/Robot/base", "/Robot/link", "X", pos0=(0, 0, 1))
    pair.joint("/Robot/ball", "SphericalJoint", "/Robot/base", "/Robot/link", pos0=(0, 0, 1))
    model, _ = pair.load()
    assert model.jnt_type.tolist() == [SLIDE, BALL]
    assert model.neq == 0


def test_more_than_six_degrees_of_freedom_between_two_bodies_are_an_error(pair):
    pair.joint("/Robot/a", "Joint", "/Robot/base", "/Robot/link")
    pair.joint("/Robot/b", "RevoluteJoint", "/Robot/base", "/Robot/link", "Y")
    with pytest.raises(UsdImportError, match=r"</Robot/b>.*7 degrees of freedom"):
        pair.load()


def test_compound_joints_that_disagree_at_zero_are_reported(pair, notes):
    pair.joint("/Robot/a", "RevoluteJoint", "/Robot/base", "/Robot/link", "X", pos0=(0, 0, 1))
    pair.joint("/Robot/b", "RevoluteJoint", "/Robot/base", "/Robot/link", "Y", pos0=(0, 0, 2))
    assert "disagree" in notes(pair.load()[1], "/Robot/b")[1][0]


def test_a_disabled_joint_is_left_out_and_reported(pair, notes):
    joint = pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    pair.attrs(joint, {"physics:jointEnabled": False})
    model, report = pair.load()
    assert model.joint("link").type[0] == mujoco.mjtJoint.mjJNT_FREE
    assert notes(report, "/Robot/j")[0] == ["the joint is disabled"]


@pytest.mark.parametrize("kind", ["RevoluteJoint", "PrismaticJoint"])
def test_passive_terms_of_the_physx_dialect(pair, kind):
    """Armature and friction effort carry no degree factor; viscous friction and velocity are per degree."""
    joint = pair.joint("/Robot/j", kind, "/Robot/base", "/Robot/link", "Z")
    token = "angular" if kind == "RevoluteJoint" else "linear"
    unit = DEG if kind == "RevoluteJoint" else 1.0
    pair.attrs(joint, {"physxJoint:armature": 0.1, "physxJoint:maxJointVelocity": 120.0}, "PhysxJointAPI")
    pair.attrs(
        joint,
        {
            f"physxJointAxis:{token}:dynamicFrictionEffort": 0.3,
            f"physxJointAxis:{token}:viscousFrictionCoefficient": 0.02,
        },
        f"PhysxJointAxisAPI:{token}",
    )
    model, report = pair.load()
    assert model.dof_armature[0] == pytest.approx(0.1)
    assert model.dof_frictionloss[0] == pytest.approx(0.3)
    assert model.dof_damping[0] == pytest.approx(0.02 / unit)
    assert report.joint_velocity_limits["j"] == pytest.approx(120.0 * unit)
    assert report.dialects["armature"] == {"physx": 1}


def test_passive_terms_of_the_newton_dialect(pair):
    joint = pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    values = {"armature": 0.2, "friction": 0.4, "damping": 0.03, "velocityLimit": 90.0}
    pair.attrs(joint, {f"newton:{k}": v for k, v in values.items()}, "NewtonJointAPI")
    model, report = pair.load()
    assert model.dof_armature[0] == pytest.approx(0.2)
    assert model.dof_frictionloss[0] == pytest.approx(0.4)
    assert model.dof_damping[0] == pytest.approx(0.03 / DEG)
    assert report.joint_velocity_limits["j"] == pytest.approx(math.pi / 2)


def test_passive_terms_of_the_mjc_dialect_are_mjcfs_own(pair):
    joint = pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", limits=(-90, 90))
    scalars = {"armature": 0.2, "frictionloss": 0.4, "damping": 0.03, "stiffness": 5.0, "margin": 0.01}
    pair.attrs(joint, {f"mjc:{k}": v for k, v in scalars.items()}, "MjcJointAPI")
    pair.attrs(joint, {"mjc:solreflimit": [0.05, 0.9], "mjc:solimplimit": [0.8, 0.9], "mjc:group": 3})
    pair.attrs(joint, {"mjc:actuatorfrcrange:min": -2.0, "mjc:actuatorfrcrange:max": 3.0, "mjc:springref": 30.0})
    model, _ = pair.load()
    assert model.dof_armature[0] == pytest.approx(0.2)
    assert model.dof_frictionloss[0] == pytest.approx(0.4)
    assert model.dof_damping[0] == pytest.approx(0.03)
    assert model.jnt_stiffness[0] == pytest.approx(5.0)
    assert model.jnt_margin[0] == pytest.approx(0.01)
    np.testing.assert_allclose(model.jnt_solref[0], (0.05, 0.9))
    np.testing.assert_allclose(model.jnt_solimp[0], (0.8, 0.9, 0.001, 0.5, 2))
    np.testing.assert_allclose(model.jnt_actfrcrange[0], (-2, 3))
    assert model.jnt_group[0] == 3
    # angles are in the compiler's unit, which MJCF takes for degrees unless told otherwise
    assert model.qpos_spring[0] == pytest.approx(30 * DEG)


def test_mjc_wins_over_newton_and_newton_over_physx(pair):
    joint = pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    pair.attrs(joint, {"physxJoint:armature": 1.0, "newton:armature": 2.0, "mjc:armature": 3.0})
    pair.attrs(joint, {"physxJoint:maxJointVelocity": 180.0, "newton:velocityLimit": math.inf})
    model, report = pair.load()
    assert model.dof_armature[0] == pytest.approx(3.0)
    assert report.dialects["armature"] == {"mjc": 1}
    assert report.dialects["velocity limit"] == {"physx": 1}
    assert report.joint_velocity_limits["j"] == pytest.approx(math.pi)


def test_load_dependent_joint_friction_is_ignored_with_a_reason(pair, notes):
    joint = pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    pair.attrs(joint, {"physxJoint:jointFriction": 0.5})
    model, report = pair.load()
    assert model.dof_frictionloss[0] == 0
    assert "load" in notes(report, "/Robot/j")[0][0]
    with pytest.raises(UsdImportError, match=r"</Robot/j>\.physxJoint:jointFriction"):
        pair.load(strict=True)


def test_negative_armature_is_an_error_that_names_joint_and_quantity(pair):
    joint = pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    pair.attrs(joint, {"physxJoint:armature": -0.1})
    with pytest.raises(UsdImportError, match=r"</Robot/j>\.armature"):
        pair.load()


def _mimic_pair(pair, kind="RevoluteJoint"):
    pair.body("/Robot/other", pos=(0, 0, 1))
    pair.joint("/Robot/lead", kind, "/Robot/base", "/Robot/link", "Z")
    return pair.joint("/Robot/follow", kind, "/Robot/base", "/Robot/other", "Z")


@pytest.mark.parametrize(("kind", "unit"), [("RevoluteJoint", DEG), ("PrismaticJoint", 1.0)])
def test_a_physx_mimic_holds_q_plus_gearing_times_reference_plus_offset_at_zero(pair, kind, unit):
    """The instance name rotX serves on a slide as well."""
    follow = _mimic_pair(pair, kind)
    pair.attrs(
        follow,
        {"physxMimicJoint:rotX:gearing": -2.0, "physxMimicJoint:rotX:offset": 3.0},
        "PhysxMimicJointAPI:rotX",
    )
    follow.CreateRelationship("physxMimicJoint:rotX:referenceJoint").SetTargets(["/Robot/lead"])
    model, report = pair.load()
    assert model.neq == 1
    assert model.eq_type[0] == mujoco.mjtEq.mjEQ_JOINT
    assert (model.eq_obj1id[0], model.eq_obj2id[0]) == (model.joint("follow").id, model.joint("lead").id)
    np.testing.assert_allclose(model.eq_data[0, :5], (-3.0 * unit, 2.0, 0, 0, 0), rtol=1e-6)
    assert report.dialects["mimic"] == {"physx": 1}


def test_a_newton_mimic_states_the_follower_by_the_leader(pair):
    follow = _mimic_pair(pair)
    pair.attrs(follow, {"newton:mimicCoef0": 10.0, "newton:mimicCoef1": -1.5}, "NewtonMimicAPI")
    follow.CreateRelationship("newton:mimicJoint").SetTargets(["/Robot/lead"])
    np.testing.assert_allclose(pair.load()[0].eq_data[0, :5], (10 * DEG, -1.5, 0, 0, 0), rtol=1e-6)
    pair.attrs(follow, {"newton:mimicEnabled": False})
    assert pair.load()[0].neq == 0


def test_an_mjc_joint_equality_is_a_quartic_polynomial(pair):
    follow = _mimic_pair(pair)
    pair.attrs(follow, {f"mjc:coef{i}": float(i) / 4 for i in range(5)}, "MjcEqualityJointAPI")
    pair.attrs(follow, {"mjc:solref": [0.03, 0.7]})
    follow.CreateRelationship("mjc:target").SetTargets(["/Robot/lead"])
    model, _ = pair.load()
    np.testing.assert_allclose(model.eq_data[0, :5], (0, 0.25, 0.5, 0.75, 1.0))
    np.testing.assert_allclose(model.eq_solref[0], (0.03, 0.7))


def test_a_mimic_of_nothing_is_an_error(pair):
    follow = _mimic_pair(pair)
    pair.set(follow, "NewtonMimicAPI")
    with pytest.raises(UsdImportError, match=r"</Robot/follow>\.newton:mimicJoint"):
        pair.load()


def test_a_mimic_pair_moves_together_in_simulation(pair):
    follow = _mimic_pair(pair)
    pair.attrs(
        follow, {"physxMimicJoint:rotZ:gearing": 1.0, "physxMimicJoint:rotZ:offset": 0.0}, "PhysxMimicJointAPI:rotZ"
    )
    follow.CreateRelationship("physxMimicJoint:rotZ:referenceJoint").SetTargets(["/Robot/lead"])
    model, _ = pair.load()
    model.opt.gravity[:] = 0
    data = mujoco.MjData(model)
    data.joint("lead").qvel[0] = 1.0
    for _ in range(200):
        mujoco.mj_step(model, data)
    assert abs(data.joint("lead").qpos[0]) > 0.05
    assert data.joint("follow").qpos[0] == pytest.approx(-data.joint("lead").qpos[0], abs=2e-3)


def test_both_sides_of_a_joint_being_one_body_is_an_error(pair):
    pair.joint("/Robot/j", "RevoluteJoint", "/Robot/link", "/Robot/link", "Z")
    with pytest.raises(UsdImportError, match=r"</Robot/j>\.physics:body1"):
        pair.load()


def test_a_joint_to_a_missing_prim_is_an_error(pair):
    pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/nowhere", "Z")
    with pytest.raises(UsdImportError, match=r"</Robot/j>\.physics:body1: no prim at </Robot/nowhere>"):
        pair.load()


def test_a_distance_joint_is_a_tendon_with_a_range(pair):
    pair.joint("/Robot/d", "DistanceJoint", "/Robot/base", "/Robot/link", pos0=(0, 0, 0.25), pos1=(0, 0, 0.5),
               **{"physics:minDistance": 0.5, "physics:maxDistance": 2.0})  # fmt: skip
    model, _ = pair.load()
    assert model.ntendon == 1
    np.testing.assert_allclose(model.tendon_range[0], (0.5, 2.0))
    assert model.joint("link").type[0] == mujoco.mjtJoint.mjJNT_FREE
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ten_length[0] == pytest.approx(1.25)


def test_nan_in_a_joint_frame_is_an_error(pair):
    joint = pair.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    UsdPhysics.Joint(joint).CreateLocalPos0Attr(Gf.Vec3f(0, math.nan, 0))
    with pytest.raises(UsdImportError, match=r"</Robot/j>\.physics:localPos0: not a number"):
        pair.load()


def test_the_effort_limit_of_a_converted_urdf_bounds_a_joint_unless_its_drive_does(pair):
    pair.body("/Robot/tip")
    free = pair.joint("/Robot/r", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", limits=(-90, 45))
    driven = pair.joint("/Robot/p", "PrismaticJoint", "/Robot/link", "/Robot/tip", "X", limits=(-0.25, 0.5))
    for joint, effort in ((free, 87.0), (driven, 12.0)):
        joint.GetPrim().CreateAttribute("urdf:limit:effort", Sdf.ValueTypeNames.Float, custom=True).Set(effort)
    drive = UsdPhysics.DriveAPI.Apply(driven.GetPrim(), "linear")
    drive.CreateMaxForceAttr(7.0)
    drive.CreateStiffnessAttr(100.0)
    model, report = pair.load()
    assert model.jnt_actfrclimited.tolist() == [1, 1]
    assert model.jnt_actfrcrange.tolist() == [[-87.0, 87.0], [-7.0, 7.0]]
    assert not report.ignored


def test_a_negative_effort_limit_is_an_error(pair):
    joint = pair.joint("/Robot/r", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    joint.GetPrim().CreateAttribute("urdf:limit:effort", Sdf.ValueTypeNames.Float, custom=True).Set(-1.0)
    with pytest.raises(UsdImportError, match="urdf:limit:effort"):
        pair.load()
