"""Bodies end up where the joint frames put them, in metres and Z-up."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

HALF = math.sqrt(0.5)
TURN_X = (HALF, HALF, 0, 0)


def _rot(quat) -> Rotation:
    return Rotation.from_quat(np.roll(np.asarray(quat, dtype=float), -1))


def _reset(model: mujoco.MjModel, qpos=None) -> mujoco.MjData:
    data = mujoco.MjData(model)
    if qpos is not None:
        data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    return data


@pytest.mark.parametrize(
    ("up", "metres", "direction", "magnitude", "expected"),
    [
        ("Z", 1.0, None, None, (0, 0, -9.81)),
        ("Y", 0.01, None, None, (0, 0, -9.81)),
        ("Z", 0.01, (0, 0, -1), 981.0, (0, 0, -9.81)),
        ("Y", 1.0, (1, 0, 0), 2.0, (2, 0, 0)),
        ("Y", 1.0, (0, 0, 1), 2.0, (0, -2, 0)),
        ("Z", 1.0, (0, 0, -1), 0.0, (0, 0, 0)),
        ("Z", 1.0, (0, 1, 0), -1.0, (0, 9.81, 0)),
    ],
)
def test_gravity_is_in_si_and_z_up_whatever_the_stage_is(author, up, metres, direction, magnitude, expected):
    from pxr import Gf, UsdPhysics

    a = author(up, metres)
    scene = UsdPhysics.Scene.Define(a.stage, "/scene")
    if direction:
        scene.CreateGravityDirectionAttr(Gf.Vec3f(*direction))
        scene.CreateGravityMagnitudeAttr(magnitude)
    a.body("/Robot/b")
    np.testing.assert_allclose(a.load()[0].opt.gravity, expected, atol=1e-6)


def test_a_stage_without_a_scene_has_earth_gravity(author):
    a = author()
    a.body("/Robot/b")
    np.testing.assert_allclose(a.load()[0].opt.gravity, (0, 0, -9.81))


def test_joint_frames_decide_the_zero_pose_and_authored_poses_only_the_initial_angle(author):
    a = author()
    a.body("/Robot/base")
    turned = Rotation.from_euler("z", 30, degrees=True).as_quat()
    a.body("/Robot/link", pos=(0, 0, 2), quat=np.roll(turned, 1))
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    a.joint("/Robot/hinge", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", pos0=(0, 0, 2))
    model, report = a.load()
    np.testing.assert_allclose(model.body("link").pos, (0, 0, 2))
    np.testing.assert_allclose(model.body("link").quat, (1, 0, 0, 0))
    assert report.initial_joint_pos["hinge"] == pytest.approx(math.radians(30), abs=1e-6)


def test_an_authored_joint_state_wins_over_the_authored_pose(author):
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link")
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    joint = a.joint("/Robot/hinge", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    a.attrs(joint, {"state:angular:physics:position": 45.0}, "PhysicsJointStateAPI:angular")
    assert a.load()[1].initial_joint_pos["hinge"] == pytest.approx(math.pi / 4)


def test_an_initial_key_holds_positions_and_controls(author):
    from lift_lab.usd import add_initial_key, load

    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link")
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    joint = a.joint("/Robot/slide", "PrismaticJoint", "/Robot/base", "/Robot/link", "Y")
    a.attrs(joint, {"state:linear:physics:position": 0.25}, "PhysicsJointStateAPI:linear")
    a.drive(joint, "linear", stiffness=10.0, targetPosition=0.5)
    spec, report = load(a.stage)
    add_initial_key(spec, report)
    model = spec.compile()
    np.testing.assert_allclose(model.key("initial").qpos, 0.25)
    np.testing.assert_allclose(model.key("initial").ctrl, 0.5)


def test_offset_frames_on_both_sides_place_the_child_and_the_axis(author):
    """Closed form: child = F0 R(axis, q) inverse(F1)."""
    a = author()
    rot0, rot1 = Rotation.from_euler("xyz", (20, -50, 70), degrees=True), Rotation.from_euler("y", 35, degrees=True)
    pos0, pos1 = np.array([0.1, -0.2, 0.3]), np.array([0.05, 0.4, -0.1])
    a.body("/Robot/base")
    a.body("/Robot/link")
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    a.joint(
        "/Robot/hinge", "RevoluteJoint", "/Robot/base", "/Robot/link", "Y",
        pos0, np.roll(rot0.as_quat(), 1), pos1, np.roll(rot1.as_quat(), 1),
    )  # fmt: skip
    model, _ = a.load()
    for q in (0.0, 0.7, -1.9):
        data = _reset(model, [q])
        rot = rot0 * Rotation.from_euler("y", q) * rot1.inv()
        np.testing.assert_allclose(data.body("link").xpos, pos0 - rot.apply(pos1), atol=1e-6)
        np.testing.assert_allclose(data.body("link").xmat.reshape(3, 3), rot.as_matrix(), atol=1e-6)


@pytest.mark.parametrize("kind", ["RevoluteJoint", "PrismaticJoint"])
def test_a_reversed_joint_keeps_the_sign_of_its_position_and_its_limits(author, kind):
    """The same joint authored child-first moves the child by the inverse of what body1 would move."""
    a = author()
    pos0, pos1 = (0.3, 0.0, 0.1), (-0.2, 0.1, 0.0)
    a.body("/Robot/base")
    a.body("/Robot/link")
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    a.joint("/Robot/j", kind, "/Robot/link", "/Robot/base", "X", pos0, TURN_X, pos1, limits=(-10, 20))
    model, _ = a.load()
    unit = math.pi / 180 if kind == "RevoluteJoint" else 1.0
    np.testing.assert_allclose(model.joint("j").range, (-10 * unit, 20 * unit), rtol=1e-6)
    q = 0.15
    data = _reset(model, [q])
    # base = link F0 M(q) inverse(F1), base at the origin.
    rot0 = _rot(TURN_X)
    turn = Rotation.from_euler("x", q) if kind == "RevoluteJoint" else Rotation.identity()
    shift = np.zeros(3) if kind == "RevoluteJoint" else np.array([q, 0, 0])
    base_in_link_rot = rot0 * turn
    base_in_link_pos = np.array(pos0) + rot0.apply(shift) - base_in_link_rot.apply(pos1)
    np.testing.assert_allclose(data.body("link").xmat.reshape(3, 3), base_in_link_rot.inv().as_matrix(), atol=1e-6)
    np.testing.assert_allclose(data.body("link").xpos, -base_in_link_rot.inv().apply(base_in_link_pos), atol=1e-6)


def test_a_joint_to_the_world_fixes_its_body_under_the_world_and_keeps_it(author):
    a = author()
    a.body("/Robot/base", pos=(1, 2, 3))
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base", pos0=(1, 2, 3))
    model, report = a.load()
    assert (model.nv, model.nbody) == (0, 2)
    np.testing.assert_allclose(model.body("base").pos, (1, 2, 3))
    assert report.root_bodies == ["base"]
    assert report.prim_paths == {"base": "/Robot/base"}


def test_a_joint_to_a_prim_without_rigid_body_is_a_joint_to_the_world(author):
    a = author()
    a.gprim("/Robot/stand", "Cube", pos=(1, 0, 0), scale=(2, 2, 2), size=1.0)
    a.body("/Robot/link", pos=(1, 0, 2))
    a.joint("/Robot/hinge", "RevoluteJoint", "/Robot/stand", "/Robot/link", "Z", pos0=(0, 0, 1))
    model, _ = a.load()
    assert model.nv == 1
    np.testing.assert_allclose(model.body("link").pos, (1, 0, 2))


def test_a_disabled_body_below_an_enabled_one_is_part_of_it(author):
    """As usd-core's parser has it: a camera with a body of its own, switched off, stays on the hand that carries it."""
    a = author()
    a.body("/Robot/hand", pos=(0, 0, 1), mass=None)
    a.gprim("/Robot/hand/palm", "Cube", size=0.1)
    camera = a.body("/Robot/hand/camera", pos=(0, 0, 0.1), mass=None)
    a.attrs(camera, {"physics:rigidBodyEnabled": False})
    a.gprim("/Robot/hand/camera/case", "Cube", size=0.05)
    a.joint("/Robot/slide", "PrismaticJoint", None, "/Robot/hand/camera", "Z", pos0=(0, 0, 1.1))
    model, _ = a.load()
    assert model.nbody == 2
    np.testing.assert_allclose(model.body("hand").mass, 1000 * (0.1**3 + 0.05**3))
    np.testing.assert_allclose(model.geom("case").pos, (0, 0, 0.1))
    np.testing.assert_allclose(model.body("hand").pos, (0, 0, 1), atol=1e-12)


def test_a_joint_frame_follows_a_scale_at_an_angle_to_its_body(author):
    """The anchor is a point of the turned link: the scale moves it as it moves the collider at the same place."""
    a = author()
    turned = (np.cos(np.pi / 8), np.sin(np.pi / 8), 0, 0)
    a.body("/Robot/b", quat=turned)
    a.gprim("/Robot/b/S", "Sphere", pos=(0, 0, 1), radius=0.1)
    a.body("/Robot/c", pos=(0, -np.sqrt(0.5), np.sqrt(0.5)), quat=turned)
    a.gprim("/Robot/c/T", "Sphere", radius=0.1)
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/b", rot0=turned)
    a.joint("/Robot/j", "RevoluteJoint", "/Robot/b", "/Robot/c", "X", pos0=(0, 0, 1))
    model, _ = a.load(scale=(1, 1, 2))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.geom("S").xpos, (0, -np.sqrt(0.5), 2 * np.sqrt(0.5)), atol=1e-6)
    np.testing.assert_allclose(data.geom("T").xpos, data.geom("S").xpos, atol=1e-6)


def test_a_fixed_world_joint_that_contradicts_the_pose_is_reported(author, notes):
    a = author()
    a.body("/Robot/base", pos=(1, 0, 0))
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    model, report = a.load()
    np.testing.assert_allclose(model.body("base").pos, (0, 0, 0))
    assert "authored pose contradicts" in notes(report, "/Robot/base")[1][0]


def test_a_body_without_a_way_to_the_world_floats_on_a_free_joint_of_its_name(author):
    a = author()
    a.body("/Robot/cube", pos=(0.5, 0, 1), quat=TURN_X)
    model, report = a.load()
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
    assert report.joints == ["cube"]
    np.testing.assert_allclose(model.qpos0, (0.5, 0, 1, *TURN_X), atol=1e-7)


def test_the_articulation_root_prim_is_the_floating_root(author):
    from pxr import UsdPhysics

    a = author()
    for name in ("first", "torso", "last"):
        a.body(f"/Robot/{name}")
    a.joint("/Robot/a", "RevoluteJoint", "/Robot/first", "/Robot/torso", "Z")
    a.joint("/Robot/b", "RevoluteJoint", "/Robot/torso", "/Robot/last", "Z")
    UsdPhysics.ArticulationRootAPI.Apply(a.stage.GetPrimAtPath("/Robot/torso"))
    model, report = a.load()
    assert report.root_bodies == ["torso"]
    assert report.articulation_roots == ["/Robot/torso"]
    assert model.body_parentid[model.body("first").id] == model.body("torso").id


def test_without_a_root_prim_the_body_that_follows_no_joint_is_the_root(author):
    a = author()
    for name in ("tip", "middle", "start"):
        a.body(f"/Robot/{name}")
    a.joint("/Robot/a", "RevoluteJoint", "/Robot/start", "/Robot/middle", "Z")
    a.joint("/Robot/b", "RevoluteJoint", "/Robot/middle", "/Robot/tip", "Z")
    assert a.load()[1].root_bodies == ["start"]


def test_a_y_up_centimetre_gram_stage_matches_its_si_twin(author):
    """The same chain authored twice; kinematics, mass matrix and gravity torques agree."""

    def chain(up, unit, grams):
        a = author(up, unit, grams)
        k, length = 1 / grams, 1 / unit

        # Y-up axes: x stays, world z is the stage's y, world y is the stage's -z.
        def v(x, y, z):
            return np.array([x, y, z] if up == "Z" else [x, z, -y]) * length

        def i(x, y, z):
            return np.array([x, y, z] if up == "Z" else [x, z, y]) * k * length**2

        a.body("/Robot/base", pos=v(0, 0, 0.5), mass=k, inertia=i(0.01, 0.01, 0.01))
        a.body("/Robot/arm", pos=v(0.1, 0, 0.8), mass=2 * k, inertia=i(0.02, 0.03, 0.04), com=v(0.05, 0.1, 0.2))
        a.body("/Robot/tip", pos=v(0.4, 0, 0.8), mass=0.5 * k, inertia=i(0.01, 0.02, 0.015), com=v(0.1, 0, 0))
        a.joint("/Robot/w", "FixedJoint", None, "/Robot/base", pos0=v(0, 0, 0.5))
        a.joint("/Robot/j1", "RevoluteJoint", "/Robot/base", "/Robot/arm", "X", pos0=v(0.1, 0, 0.3), limits=(-90, 45))
        slide = a.joint(
            "/Robot/j2", "PrismaticJoint", "/Robot/arm", "/Robot/tip", "Z" if up == "Z" else "Y", pos0=v(0.3, 0, 0),
            limits=(-0.1 * length, 0.2 * length),
        )  # fmt: skip
        a.drive(slide, "linear", stiffness=100.0 * k, damping=10.0 * k, maxForce=50.0 * k * length)
        return a.load()[0]

    si, cgs = chain("Z", 1.0, 1.0), chain("Y", 0.01, 0.001)
    for model in (si, cgs):
        assert model.nv == 2
    np.testing.assert_allclose(cgs.jnt_range, si.jnt_range, rtol=1e-6)
    np.testing.assert_allclose(cgs.jnt_actfrcrange, si.jnt_actfrcrange, rtol=1e-6)
    np.testing.assert_allclose(cgs.actuator_gainprm, si.actuator_gainprm, rtol=1e-6)
    np.testing.assert_allclose(cgs.actuator_biasprm, si.actuator_biasprm, rtol=1e-6)
    for q in ((0, 0), (0.3, 0.1), (-1.2, -0.05)):
        results = []
        for model in (si, cgs):
            data = _reset(model, q)
            mass = np.zeros((2, 2))
            mujoco.mj_fullM(model, data, mass)
            results.append((data.xipos.copy(), mass, data.qfrc_bias.copy()))
        for one, other in zip(*results, strict=True):
            np.testing.assert_allclose(other, one, atol=2e-6)


def test_the_scale_option_scales_lengths_and_leaves_masses(author):
    a = author()
    a.body("/Robot/base", mass=3.0)
    a.body("/Robot/link", pos=(0, 0, 1), mass=2.0, com=(0, 0, 0.5))
    a.gprim("/Robot/link/c", "Cube", size=0.2)
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/base")
    a.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "X", pos0=(0, 0, 1))
    model, _ = a.load(scale=0.5)
    np.testing.assert_allclose(model.body("link").pos, (0, 0, 0.5))
    np.testing.assert_allclose(model.body("link").ipos, (0, 0, 0.25))
    np.testing.assert_allclose(model.geom("c").size, (0.05, 0.05, 0.05))
    assert model.body("link").mass == pytest.approx(2.0)
    stretched, _ = a.load(scale=(1, 1, 2))
    np.testing.assert_allclose(stretched.geom("c").size, (0.1, 0.1, 0.2))
    assert not a.stage.GetPrimAtPath("/Robot").GetAttribute("xformOp:scale:import")


def test_a_scaled_parent_scales_prismatic_offsets_but_not_limits(author):
    a = author()
    a.place(a.stage.GetPrimAtPath("/Robot"), scale=(2, 2, 2))
    a.body("/Robot/base")
    a.body("/Robot/link", pos=(0, 0, 1))
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/base")
    a.joint("/Robot/j", "PrismaticJoint", "/Robot/base", "/Robot/link", "X", pos0=(0, 0, 1), limits=(-0.1, 0.3))
    model, _ = a.load()
    np.testing.assert_allclose(model.body("link").pos, (0, 0, 2))
    np.testing.assert_allclose(model.joint("j").range, (-0.1, 0.3), rtol=1e-6)


def test_kinematic_bodies_become_mocap_and_disabled_ones_static(author):
    a = author()
    kinematic = a.body("/Robot/k", pos=(1, 0, 0))
    a.attrs(kinematic, {"physics:kinematicEnabled": True})
    a.attrs(a.body("/Robot/off", pos=(2, 0, 0)), {"physics:rigidBodyEnabled": False})
    model, _ = a.load()
    assert (model.nmocap, model.nv) == (1, 0)
    assert model.body("k").mocapid[0] == 0
    np.testing.assert_allclose(model.body("off").pos, (2, 0, 0))


def test_a_nested_rigid_body_is_a_body_of_its_own(author):
    a = author()
    a.body("/Robot/outer", pos=(1, 0, 0))
    a.body("/Robot/outer/inner", pos=(0, 0, 1))
    a.gprim("/Robot/outer/inner/c", "Sphere", radius=0.1)
    model, report = a.load()
    assert report.root_bodies == ["outer", "inner"]
    np.testing.assert_allclose(model.body("inner").pos, (1, 0, 1))
    assert model.geom("c").bodyid[0] == model.body("inner").id


def test_names_that_collide_take_their_parents_name(author):
    a = author()
    a.body("/Robot/left/link")
    a.body("/Robot/right/link")
    a.gprim("/Robot/left/link/c", "Sphere", radius=0.1)
    a.gprim("/Robot/right/link/c", "Sphere", radius=0.1)
    model, report = a.load()
    assert report.bodies == ["link", "right_link"]
    assert [model.geom(i).name for i in range(2)] == ["c", "link_c"]
    assert report.prim_paths == {"link": "/Robot/left/link", "right_link": "/Robot/right/link"}
