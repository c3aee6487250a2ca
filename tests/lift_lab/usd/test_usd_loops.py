"""Joints that close loops, or stay out of the articulation, become equalities that hold in simulation."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

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


def test_a_loop_that_has_no_equality_is_reported(chain, notes):
    chain.joint("/Robot/p", "PrismaticJoint", "/Robot/left", "/Robot/right", "X", pos0=(1, 0, 0))
    model, report = chain.load()
    assert model.neq == 0
    assert "no equality" in notes(report, "/Robot/p")[0][0]


def test_a_joint_that_holds_a_kinematic_body_is_superfluous(author, notes):
    a = author()
    a.attrs(a.body("/Robot/k"), {"physics:kinematicEnabled": True})
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/k")
    model, report = a.load()
    assert (model.neq, model.nmocap) == (0, 1)
    assert "held already" in notes(report, "/Robot/w")[0][0]
