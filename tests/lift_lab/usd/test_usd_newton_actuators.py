"""NewtonActuator prims apply their control law, in radians and the stage's units."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from lift_lab.usd import UsdImportError


@pytest.fixture
def joint(author):
    """Base, link and one joint about or along Z in a stage of the given units; returns the author."""

    def make(kind="RevoluteJoint", metres=1.0):
        a = author("Z", metres)
        a.body("/Robot/base")
        a.body("/Robot/link", mass=2.0, inertia=(0.1, 0.2, 0.3))
        a.joint("/Robot/weld", "FixedJoint", None, "/Robot/base")
        a.joint("/Robot/j", kind, "/Robot/base", "/Robot/link", "Z")
        return a

    return make


def _actuator(a, *schemas, target="/Robot/j", **values):
    prim = a.stage.DefinePrim("/Robot/motor", "NewtonActuator")
    for schema in schemas:
        a.set(prim, schema)
    a.attrs(prim, {f"newton:{name}": value for name, value in values.items()})
    if target:
        prim.CreateRelationship("newton:targets").SetTargets([target])
    return prim


def _effort(model, q, v, ctrl):
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0], data.ctrl[0] = q, v, ctrl
    mujoco.mj_forward(model, data)
    return data.qfrc_actuator[0]


@pytest.mark.parametrize(("kind", "unit"), [("RevoluteJoint", 1e-4), ("PrismaticJoint", 1.0)])
def test_a_pd_law_is_per_radian_or_metre_whatever_the_stages_metre(joint, kind, unit):
    """In a centimetre stage a torque is 1e-4 N m, a force 0.01 N, and force over length stays as it is."""
    a = joint(kind, metres=0.01)
    _actuator(a, "NewtonPDControlAPI", kp=300.0, kd=20.0, constEffort=5.0)
    model, report = a.load()
    assert report.actuators == ["motor"]
    assert report.dialects["actuator"] == {"newton": 1}
    effort = 1e-4 if kind == "RevoluteJoint" else 1e-2
    expected = 5.0 * effort + unit * (300.0 * (0.7 - 0.2) - 20.0 * 0.4)
    assert _effort(model, 0.2, 0.4, 0.7) == pytest.approx(expected, rel=1e-5)


def test_an_actuator_that_may_give_no_effort_is_none(joint):
    a = joint()
    _actuator(a, "NewtonPDControlAPI", "NewtonMaxEffortClampingAPI", kp=300.0, maxEffort=0.0)
    assert a.load()[0].nu == 0  # MuJoCo cannot compile an empty force range


def test_max_effort_clamps_the_actuator(joint):
    a = joint()
    _actuator(a, "NewtonPDControlAPI", "NewtonMaxEffortClampingAPI", kp=300.0, maxEffort=12.0)
    model, _ = a.load()
    assert _effort(model, 0.0, 0.0, 1.0) == pytest.approx(12.0)
    assert _effort(model, 0.0, 0.0, 0.02) == pytest.approx(6.0)


def test_without_stiffness_the_command_is_a_velocity(joint):
    a = joint()
    _actuator(a, "NewtonPDControlAPI", kd=4.0)
    assert _effort(a.load()[0], 0.3, 0.5, 2.0) == pytest.approx(4.0 * (2.0 - 0.5))


def test_it_stands_beside_the_joints_own_drive(joint):
    a = joint()
    a.drive(a.stage.GetPrimAtPath("/Robot/j"), stiffness=1.0)
    _actuator(a, "NewtonPDControlAPI", kp=5.0)
    assert a.load()[1].actuators == ["j", "motor"]


def test_a_dc_motor_keeps_its_stall_effort_and_gives_the_velocity_limit(joint, notes):
    a = joint()
    _actuator(
        a, "NewtonPDControlAPI", "NewtonDCMotorClampingAPI",
        kp=1000.0, saturationEffort=30.0, maxMotorEffort=20.0, velocityLimit=7.0,
    )  # fmt: skip
    model, report = a.load()
    assert report.joint_velocity_limits == {"j": 7.0}
    np.testing.assert_allclose(model.actuator_forcerange[0], (-20, 20))
    assert "stall" in notes(report, "/Robot/motor")[1][0]


def test_a_table_of_efforts_bounds_by_its_largest(joint, notes):
    a = joint()
    prim = _actuator(a, "NewtonPDControlAPI", "NewtonPositionBasedClampingAPI", kp=1000.0)
    a.attrs(prim, {"newton:lookupPositions": [-1.0, 0.0, 1.0], "newton:lookupEfforts": [5.0, 9.0, 4.0]})
    model, report = a.load()
    np.testing.assert_allclose(model.actuator_forcerange[0], (-9, 9))
    assert "table" in notes(report, "/Robot/motor")[1][0]


def test_what_a_pd_actuator_lacks_is_reported_and_strict_refuses_it(joint, notes):
    a = joint()
    _actuator(a, "NewtonPIDControlAPI", "NewtonActuatorDelayAPI", kp=3.0, ki=1.0, delaySteps=2)
    model, report = a.load()
    assert model.actuator_gainprm[0, 0] == pytest.approx(3.0)
    assert notes(report, "/Robot/motor")[0] == ["PD actuators have no integral", "commands are not delayed"]
    with pytest.raises(UsdImportError, match=r"</Robot/motor>\.newton:ki"):
        a.load(strict=True)


@pytest.mark.parametrize(
    ("schemas", "message"), [((), "without a control law"), (("NewtonNeuralControlAPI",), "neural control law")]
)
def test_a_law_that_is_not_known_makes_no_actuator(joint, notes, schemas, message):
    a = joint()
    _actuator(a, *schemas)
    model, report = a.load()
    assert model.nu == 0
    assert message in notes(report, "/Robot/motor")[0][0]


@pytest.mark.parametrize(
    ("options", "attribute"),
    [
        ({"target": None}, "newton:targets"),
        ({"target": "/Robot/link"}, "newton:targets"),
        ({"target": "/Robot/weld"}, "newton:targets"),
        ({"kp": -1.0}, "newton:kp"),
        ({"kd": float("nan")}, "newton:kd"),
    ],
)
def test_impossible_actuators_are_errors_that_name_prim_and_attribute(joint, options, attribute):
    a = joint()
    _actuator(a, "NewtonPDControlAPI", **options)
    with pytest.raises(UsdImportError, match=rf"</Robot/motor>\.{attribute}"):
        a.load()
