"""Joints that close loops, or stay out of the articulation, become equalities that hold in simulation."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from pxr import UsdPhysics

CONNECT, WELD = int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD)


@pytest.fixture
def chain(author):
    """Two links on sliding-free hinges under a welded base, tips 1 m apart at position zero."""
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/left", pos=(0, 0, 0), com=(0, 0, 0.5))
    a.body("/Robot/right", pos=(1, 0, 0), com=(0, 0, 0.5))
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    a.joint("/Robot/l", "RevoluteJoint", "/Robot/base", "/Robot/left", "Y")
    a.joint("/Robot/r", "RevoluteJoint", "/Robot/base", "/Robot/right", "Y", pos0=(1, 0, 0))
    return a


def test_a_four_bar_keeps_its_loop_closed(chain):
    """A coupler across the tops: the joint authored last closes the loop with two connects along its axis."""
    chain.body("/Robot/coupler", pos=(0, 0, 1), com=(0.5, 0, 0))
    chain.joint("/Robot/c1", "RevoluteJoint", "/Robot/left", "/Robot/coupler", "Y", pos0=(0, 0, 1))
    chain.joint("/Robot/c2", "RevoluteJoint", "/Robot/coupler", "/Robot/right", "Y", pos0=(1, 0, 0), pos1=(0, 0, 1))
    model, report = chain.load()
    assert model.eq_type.tolist() == [CONNECT, CONNECT]
    assert report.joints == ["l", "c1", "r"]
    data = mujoco.MjData(model)
    data.joint("l").qvel[0] = data.joint("r").qvel[0] = 0.5
    data.joint("c1").qvel[0] = -0.5
    for _ in range(300):
        mujoco.mj_step(model, data)
    assert abs(data.joint("l").qpos[0]) > 0.1
    top = data.body("coupler").xpos + data.body("coupler").xmat.reshape(3, 3) @ [1, 0, 0]
    other = data.body("right").xpos + data.body("right").xmat.reshape(3, 3) @ [0, 0, 1]
    np.testing.assert_allclose(top, other, atol=2e-3)
    # a parallelogram keeps its coupler level
    np.testing.assert_allclose(data.body("coupler").xquat, (1, 0, 0, 0), atol=2e-3)


def test_an_explicitly_excluded_joint_is_the_one_that_closes_the_loop(chain):
    chain.body("/Robot/coupler", pos=(0, 0, 1), com=(0.5, 0, 0))
    cut = chain.joint("/Robot/c1", "SphericalJoint", "/Robot/left", "/Robot/coupler", pos0=(0, 0, 1))
    chain.attrs(cut, {"physics:excludeFromArticulation": True})
    chain.joint("/Robot/c2", "RevoluteJoint", "/Robot/coupler", "/Robot/right", "Y", pos0=(1, 0, 0), pos1=(0, 0, 1))
    model, report = chain.load()
    assert report.joints == ["l", "r", "c2"]
    assert model.eq_type.tolist() == [CONNECT]
    assert [model.site(int(i)).name for i in (model.eq_obj1id[0], model.eq_obj2id[0])] == ["c1_0", "c1_1"]
    np.testing.assert_allclose(model.site("c1_0").pos, (0, 0, 1))
    np.testing.assert_allclose(model.site("c1_1").pos, (0, 0, 0))
    # c2 runs against the tree: the coupler hangs under the right link
    assert model.body_parentid[model.body("coupler").id] == model.body("right").id


def test_an_excluded_fixed_joint_is_a_weld_that_holds_the_relative_pose(author):
    a = author()
    a.body("/Robot/a", pos=(0, 0, 1))
    a.body("/Robot/b", pos=(0, 0.5, 1))
    weld = a.joint("/Robot/w", "FixedJoint", "/Robot/a", "/Robot/b", pos0=(0, 0.5, 0))
    a.attrs(weld, {"physics:excludeFromArticulation": True, "mjc:torqueScale": 2.5, "mjc:solref": [0.01, 1.2]})
    model, _ = a.load()
    assert model.eq_type.tolist() == [WELD]
    assert model.eq_data[0, 10] == pytest.approx(2.5)
    np.testing.assert_allclose(model.eq_solref[0], (0.01, 1.2))
    data = mujoco.MjData(model)
    data.joint("a").qvel[3:] = (1.0, 2.0, 0.5)
    for _ in range(200):
        mujoco.mj_step(model, data)
    a_rot = data.body("a").xmat.reshape(3, 3)
    np.testing.assert_allclose(a_rot.T @ (data.body("b").xpos - data.body("a").xpos), (0, 0.5, 0), atol=5e-3)
    np.testing.assert_allclose(a_rot.T @ data.body("b").xmat.reshape(3, 3), np.eye(3), atol=2e-2)


def test_an_excluded_joint_to_the_world_holds_its_body_there(author):
    a = author()
    a.body("/Robot/ball", pos=(0, 0, 1))
    pin = a.joint("/Robot/pin", "SphericalJoint", None, "/Robot/ball", pos0=(0, 0, 1.5), pos1=(0, 0, 0.5))
    a.attrs(pin, {"physics:excludeFromArticulation": True})
    model, _ = a.load()
    data = mujoco.MjData(model)
    for _ in range(500):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.body("ball").xpos, (0, 0, 1), atol=2e-3)


def _spin(model, steps, **velocities):
    """Simulate without gravity from the given joint velocities."""
    model.opt.gravity[:] = 0
    data = mujoco.MjData(model)
    for joint, velocity in velocities.items():
        data.joint(joint).qvel = velocity
    for _ in range(steps):
        mujoco.mj_step(model, data)
    return data


def test_a_slider_crank_closed_by_its_slide_follows_the_closed_form(author, notes):
    """x = r cos(t) + sqrt(l^2 - r^2 sin(t)^2), whichever joint closes the loop."""
    r, length, speed = 0.3, 0.8, 1.5
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/crank", com=(r / 2, 0, 0))
    a.body("/Robot/rod", pos=(r, 0, 0), com=(length / 2, 0, 0))
    a.body("/Robot/piston", pos=(r + length, 0, 0))
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    a.joint("/Robot/hub", "RevoluteJoint", "/Robot/base", "/Robot/crank", "Y")
    a.joint("/Robot/big", "RevoluteJoint", "/Robot/crank", "/Robot/rod", "Y", pos0=(r, 0, 0))
    a.joint("/Robot/pin", "RevoluteJoint", "/Robot/rod", "/Robot/piston", "Y", pos0=(length, 0, 0))
    slide = a.joint("/Robot/slide", "PrismaticJoint", "/Robot/base", "/Robot/piston", "X", pos0=(r + length, 0, 0))
    a.attrs(slide, {"physics:excludeFromArticulation": True})
    model, report = a.load()
    assert model.eq_type.tolist() == [WELD]
    assert sorted(report.joints) == ["big", "hub", "pin", "slide"]
    assert "carrier" in notes(report, "/Robot/slide")[1][0]
    rod = -r * speed / length
    data = _spin(model, 400, hub=speed, big=rod - speed, pin=-rod)
    angle = data.joint("hub").qpos[0]
    assert angle > 0.7
    expected = r * np.cos(angle) + np.sqrt(length**2 - (r * np.sin(angle)) ** 2)
    np.testing.assert_allclose(data.body("piston").xpos, (expected, 0, 0), atol=2e-3)
    assert data.joint("slide").qpos[0] == pytest.approx(expected - r - length, abs=2e-3)


def _puck(author, low, high):
    """A free body that a D6 joint to the world keeps at z = 1, upright, x within [low, high]."""
    a = author()
    a.body("/Robot/puck", pos=(0, 0, 1))
    joint = a.joint("/Robot/plane", "Joint", None, "/Robot/puck", pos0=(0, 0, 1))
    a.attrs(joint, {"physics:excludeFromArticulation": True})
    for token, bounds in (("transX", (low, high)), ("transZ", (1, -1)), ("rotX", (1, -1)), ("rotY", (1, -1))):
        limit = UsdPhysics.LimitAPI.Apply(joint, token)
        limit.CreateLowAttr(float(bounds[0]))
        limit.CreateHighAttr(float(bounds[1]))
    return a


def test_a_d6_joint_that_closes_a_loop_keeps_its_free_axes_free(author):
    model, _ = _puck(author, -1.0, 1.0).load()
    assert model.eq_type.tolist() == [WELD]
    data = mujoco.MjData(model)
    data.joint("puck").qvel = (0.3, -0.2, 0, 0, 0, 1.0)
    for name, speed in (("plane_transX", 0.3), ("plane_transY", -0.2), ("plane_rotZ", 1.0)):
        data.joint(name).qvel = speed
    for _ in range(250):
        mujoco.mj_step(model, data)
    np.testing.assert_allclose(data.body("puck").xpos, (0.15, -0.1, 1.0), atol=3e-3)
    turn = data.body("puck").xmat.reshape(3, 3)
    np.testing.assert_allclose(turn[:, 0], (np.cos(0.5), np.sin(0.5), 0), atol=5e-3)


def test_limits_of_a_joint_that_closes_a_loop_hold(author):
    model, _ = _puck(author, -0.1, 0.1).load()
    data = _spin(model, 600, puck=(0.5, 0, 0, 0, 0, 0), plane_transX=0.5)
    assert data.body("puck").xpos[0] <= 0.105


def _driven_four_bar(chain, excluded):
    chain.body("/Robot/coupler", pos=(0, 0, 1), com=(0.5, 0, 0))
    chain.joint("/Robot/c1", "RevoluteJoint", "/Robot/left", "/Robot/coupler", "Y", pos0=(0, 0, 1))
    last = chain.joint(
        "/Robot/c2", "RevoluteJoint", "/Robot/coupler", "/Robot/right", "Y", pos0=(1, 0, 0), pos1=(0, 0, 1)
    )
    degree = np.pi / 180
    chain.drive(last, stiffness=50 * degree, damping=18 * degree, targetPosition=20.0)
    if excluded:
        chain.attrs(last, {"physics:excludeFromArticulation": True})
    return chain.load()


@pytest.mark.parametrize("excluded", [False, True])
def test_a_driven_joint_moves_its_loop_whether_or_not_it_closes_it(chain, excluded):
    """A parallelogram whose drive wants 20 degrees; left to choose, the importer cuts a joint without drive."""
    model, report = _driven_four_bar(chain, excluded)
    assert model.eq_type.tolist() == ([WELD] if excluded else [CONNECT, CONNECT])
    assert report.actuators == ["c2"]
    model.opt.gravity[:] = 0
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    data.actuator("c2").ctrl = report.initial_ctrl["c2"]
    for _ in range(1500):
        mujoco.mj_step(model, data)
    assert data.joint("c2").qpos[0] == pytest.approx(np.radians(20), abs=0.01)
    axis = data.body("left").xmat.reshape(3, 3)[:, 2]
    np.testing.assert_allclose(axis, (np.sin(np.radians(20)), 0, np.cos(np.radians(20))), atol=0.01)


def test_a_carrier_starts_where_the_authored_poses_put_it(author):
    a = _puck(author, -1.0, 1.0)
    for token in ("transY", "rotZ"):
        limit = UsdPhysics.LimitAPI.Apply(a.stage.GetPrimAtPath("/Robot/plane"), token)
        limit.CreateLowAttr(1.0)
        limit.CreateHighAttr(-1.0)
    a.stage.GetPrimAtPath("/Robot/puck").GetAttribute("xformOp:translate").Set((0.25, 0, 1))
    assert a.load()[1].initial_joint_pos == pytest.approx({"plane": 0.25})


def test_a_joint_that_holds_a_kinematic_body_is_superfluous(author, notes):
    a = author()
    a.attrs(a.body("/Robot/k"), {"physics:kinematicEnabled": True})
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/k")
    model, report = a.load()
    assert (model.neq, model.nmocap) == (0, 1)
    assert "held already" in notes(report, "/Robot/w")[0][0]
