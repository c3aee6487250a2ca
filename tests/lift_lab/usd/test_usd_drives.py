"""Drives become actuators that apply the authored force."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest

from lift_lab.usd import UsdImportError

DEG = math.pi / 180


@pytest.fixture
def driven(author):
    """Base, link and a joint of the given kind with a drive; returns the author and the joint prim."""

    def make(kind="RevoluteJoint", **values):
        a = author()
        a.body("/Robot/base")
        a.body("/Robot/link", pos=(0, 0, 1), mass=2.0, inertia=(0.1, 0.2, 0.3))
        a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
        joint = a.joint("/Robot/j", kind, "/Robot/base", "/Robot/link", "Z", pos0=(0, 0, 1))
        token = "angular" if kind == "RevoluteJoint" else "linear"
        a.drive(joint, token, **values)
        return a, joint

    return make


def _force(model, report, q, v, use_targets=True):
    """Joint torque of all actuators at a state, with the controls the stage asks for."""
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = q, v
    if use_targets:
        for name, value in report.initial_ctrl.items():
            data.ctrl[model.actuator(name).id] = value
    mujoco.mj_forward(model, data)
    return data.qfrc_actuator[0]


def test_gains_of_an_angular_drive_are_per_degree(driven):
    """Isaac's 400 N m/rad is authored as 6.9813 N m/deg."""
    a, _ = driven(stiffness=400 * DEG, damping=80 * DEG, maxForce=87.0)
    model, report = a.load()
    assert report.actuators == ["j"]
    assert model.actuator_gainprm[0, 0] == pytest.approx(400, rel=1e-6)
    np.testing.assert_allclose(model.actuator_biasprm[0, :3], (0, -400, -80), rtol=1e-6)
    np.testing.assert_allclose(model.jnt_actfrcrange[0], (-87, 87))
    assert model.actuator_forcelimited[0] == 0


def test_gains_of_a_linear_drive_are_per_metre(driven):
    a, _ = driven("PrismaticJoint", stiffness=2e3, damping=100.0)
    model, _ = a.load()
    assert model.actuator_gainprm[0, 0] == pytest.approx(2000)
    np.testing.assert_allclose(model.actuator_biasprm[0, :3], (0, -2000, -100))
    assert model.jnt_actfrclimited[0] == 0


@pytest.mark.parametrize(
    ("stiffness", "damping", "position", "velocity"),
    [(3.0, 0.5, 20.0, 0.0), (3.0, 0.5, 20.0, 30.0), (0.0, 0.5, 0.0, 30.0), (3.0, 0.0, -10.0, 0.0)],
)
def test_the_actuators_apply_the_drives_force_law(driven, stiffness, damping, position, velocity):
    a, _ = driven(stiffness=stiffness, damping=damping, targetPosition=position, targetVelocity=velocity)
    model, report = a.load()
    q, v = 0.3, -0.7
    expected = stiffness * (position - q / DEG) + damping * (velocity - v / DEG)
    assert _force(model, report, q, v) == pytest.approx(expected, rel=1e-5)


def test_max_force_bounds_the_sum_of_a_joints_actuators(driven):
    a, _ = driven(stiffness=30.0, damping=5.0, targetPosition=20.0, targetVelocity=30.0, maxForce=7.0)
    model, report = a.load()
    assert model.nu == 2
    assert _force(model, report, 0.0, 0.0) == pytest.approx(7.0)


def test_a_drive_without_gains_makes_no_actuator_but_bounds_the_joint(driven):
    a, _ = driven(stiffness=0.0, damping=0.0, maxForce=9.0)
    model, _ = a.load()
    assert model.nu == 0
    np.testing.assert_allclose(model.jnt_actfrcrange[0], (-9, 9))


def test_an_acceleration_drive_is_scaled_by_the_joints_inertia(driven, notes):
    """Acceleration = k (target - q) in the reference pose: force / M = authored gain."""
    a, _ = driven(stiffness=50 * DEG, damping=4 * DEG, type="acceleration", targetPosition=90.0)
    model, report = a.load()
    inertia = 0.3  # about Z through the origin of the link
    assert model.actuator_gainprm[0, 0] == pytest.approx(50 * inertia, rel=1e-5)
    assert _force(model, report, 0.0, 0.0) == pytest.approx(50 * inertia * math.pi / 2, rel=1e-5)
    assert "per unit inertia" in notes(report, "j")[1][0]


def test_a_reversed_drive_pushes_towards_its_target(author):
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link")
    a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
    joint = a.joint("/Robot/j", "RevoluteJoint", "/Robot/link", "/Robot/base", "Z")
    a.drive(joint, stiffness=1.0, targetPosition=10.0)
    model, report = a.load()
    assert _force(model, report, 0.0, 0.0) == pytest.approx(10.0, rel=1e-5)


@pytest.mark.parametrize("values", [{"stiffness": -1.0}, {"damping": -1.0}, {"stiffness": 1.0, "maxForce": -2.0}])
def test_negative_gains_and_bounds_are_errors(driven, values):
    a, _ = driven(**values)
    with pytest.raises(UsdImportError, match="/Robot/j"):
        a.load()


def test_a_drive_that_may_not_push_is_left_out(driven):
    a, _ = driven(stiffness=30.0, damping=5.0, maxForce=0.0)
    model, _ = a.load()
    assert model.nu == 0
    assert not model.jnt_actfrclimited.any()


def test_drives_that_nothing_reads_are_reported(author, notes):
    """usd-core reads no drive of a spherical joint, and none whose DriveAPI is not applied."""
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link")
    a.body("/Robot/tip")
    ball = a.joint("/Robot/ball", "SphericalJoint", "/Robot/base", "/Robot/link")
    a.drive(ball, "rotX", stiffness=10.0)
    hinge = a.joint("/Robot/hinge", "RevoluteJoint", "/Robot/link", "/Robot/tip", "Z")
    a.attrs(hinge, {"drive:angular:physics:stiffness": 10.0})
    model, report = a.load()
    assert model.nu == 0
    assert notes(report, "/Robot/ball")[0] == ["a spherical joint has no drive of this name"]
    assert notes(report, "/Robot/hinge")[0] == ["PhysicsDriveAPI:angular is not applied to the prim"]
