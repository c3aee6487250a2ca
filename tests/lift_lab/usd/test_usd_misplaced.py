"""Physics that has no effect because of where it stands is reported, and strict refuses it."""

from __future__ import annotations

import pytest
from pxr import Gf, UsdGeom, UsdPhysics

from lift_lab.usd import UsdImportError


def _of(report, path) -> dict[str, str]:
    return {note.attribute: note.reason for note in report.ignored if note.prim_path == path and not note.tuning}


@pytest.mark.parametrize(
    ("kind", "attributes", "hint"),
    [
        ("RevolutePhysicsJoint", {"physics:axis": "Y", "physics:lowerLimit": -10.0}, "'PhysicsRevoluteJoint'"),
        ("PhysicsRevolutJoint", {"physics:upperLimit": 10.0}, "'PhysicsRevoluteJoint'"),
        ("PhysicsScen", {"physics:gravityMagnitude": 1.0}, "'PhysicsScene'"),
        ("PhysicsFixdJoint", {}, "'PhysicsFixedJoint'"),
        ("Something", {"mjc:armature": 1.0}, "no prim type"),
        ("Xfrom", {"physxRigidBody:disableGravity": True}, "'Xform'"),
    ],
)
def test_a_prim_type_that_usd_does_not_know_is_reported_once(author, kind, attributes, hint):
    a = author()
    a.body("/Robot/a")
    a.attrs(a.stage.DefinePrim("/Robot/thing", kind), attributes)
    found = _of(a.load()[1], "/Robot/thing")
    assert list(found) == [kind]
    assert hint in found[kind]
    with pytest.raises(UsdImportError, match=rf"</Robot/thing>\.{kind}: ignored"):
        a.load(strict=True)


def test_a_prim_type_that_has_nothing_to_do_with_physics_is_not_reported(author):
    a = author()
    a.body("/Robot/a")
    a.attrs(a.stage.DefinePrim("/Robot/graph", "OmniGraph"), {"node:type": "x"})
    assert a.load(strict=True)[1].ignored == []


@pytest.mark.parametrize(
    ("schema", "right"),
    [
        ("PhysicsRigidBodyApi", "PhysicsRigidBodyAPI"),
        ("RigidBodyAPI", "PhysicsRigidBodyAPI"),
        ("PhysicsColisionAPI", "PhysicsCollisionAPI"),
        ("PhysicsDriveApi:angular", "PhysicsDriveAPI"),
    ],
)
def test_a_misspelt_schema_is_reported(author, schema, right):
    a = author()
    a.set(a.gprim("/Robot/box", "Cube", collider=False, size=0.2), schema)
    found = _of(a.load()[1], "/Robot/box")
    assert f"did you mean '{right}'?" in found[schema]
    with pytest.raises(UsdImportError, match=f"</Robot/box>.{schema}"):
        a.load(strict=True)


@pytest.mark.parametrize(
    "schema",
    [
        "PhysxRigidBodyAPI",
        "NewtonMassAPI",
        "MjcCollisionAPI",
        "PhysicsJointStateAPI:angular",
        "TensorPhysicsArticulationRootAPI",
    ],
)
def test_schemas_of_vendors_are_no_misspellings(author, schema):
    a = author()
    a.set(a.gprim("/Robot/box", "Cube", size=0.2), schema)
    assert a.load(strict=True)[1].ignored == []


@pytest.mark.parametrize(
    ("attributes", "lacks"),
    [
        ({"physics:lowerLimit": -10.0}, "no PhysicsJoint"),
        ({"state:angular:physics:position": 10.0}, "no PhysicsJoint"),
        ({"physxJoint:armature": 1.0}, "no PhysicsJoint"),
        ({"newton:armature": 1.0}, "no PhysicsJoint"),
        ({"physics:kinematicEnabled": True}, "PhysicsRigidBodyAPI is not applied"),
        ({"physxRigidBody:disableGravity": True}, "PhysicsRigidBodyAPI is not applied"),
        ({"physics:approximation": "convexHull"}, "PhysicsMeshCollisionAPI is not applied"),
        ({"physics:dynamicFriction": 1.0}, "PhysicsMaterialAPI is not applied"),
        ({"physics:mass": 1.0}, "PhysicsMassAPI is not applied"),
        ({"newton:inertia": [1.0] * 6}, "PhysicsMassAPI is not applied"),
        ({"physics:gravityMagnitude": 1.0}, "no PhysicsScene"),
        ({"mjc:option:cone": "elliptic"}, "no PhysicsScene"),
        ({"physics:mergeGroup": "a"}, "no PhysicsCollisionGroup"),
        ({"physxArticulation:enabledSelfCollisions": False}, "PhysicsArticulationRootAPI is not applied"),
    ],
)
def test_an_attribute_without_its_type_or_schema_is_reported(author, attributes, lacks):
    a = author()
    a.attrs(UsdGeom.Xform.Define(a.stage, "/Robot/thing").GetPrim(), attributes)
    a.body("/Robot/a")
    found = _of(a.load()[1], "/Robot/thing")
    assert list(found) == list(attributes)
    assert lacks in found[next(iter(attributes))]


def test_actuators_may_have_attributes_of_joints(author):
    """The clamp of a DC motor has a `newton:velocityLimit`, a tendon `mjc:armature`."""
    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link", pos=(0, 0, 1))
    a.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    motor = a.stage.DefinePrim("/Robot/motor", "NewtonActuator")
    motor.CreateRelationship("newton:targets").AddTarget("/Robot/j")
    for schema in ("NewtonPDControlAPI", "NewtonDCMotorClampingAPI"):
        motor.AddAppliedSchema(schema)
    limits = {"newton:saturationEffort": 9.0, "newton:maxMotorEffort": 5.0, "newton:velocityLimit": 7.0}
    a.attrs(motor, {"newton:kp": 3.0, **limits})
    assert _of(a.load()[1], "/Robot/motor") == {}


def test_offsets_without_a_collider_are_reported(author):
    a = author()
    a.attrs(a.gprim("/Robot/box", "Cube", collider=False, size=0.2), {"physxCollision:restOffset": 0.1})
    assert "PhysicsCollisionAPI" in _of(a.load()[1], "/Robot/box")["physxCollision:restOffset"]


def test_limits_that_a_joint_does_not_have_are_reported(author):
    a = author()
    a.body("/Robot/a")
    a.body("/Robot/b")
    joint = a.joint("/Robot/j", "RevoluteJoint", "/Robot/a", "/Robot/b", "X")
    UsdPhysics.LimitAPI.Apply(joint, "rotX").CreateLowAttr(-10.0)
    assert "revolute joint has no limit" in _of(a.load()[1], "/Robot/j")["limit:rotX"]


def test_a_drive_that_a_joint_does_not_have_is_reported_if_it_has_gains(author):
    a = author()
    a.body("/Robot/a")
    a.body("/Robot/b")
    joint = a.joint("/Robot/j", "RevoluteJoint", "/Robot/a", "/Robot/b", "X")
    a.drive(joint, "X", stiffness=0.0, damping=0.0, maxForce=0.0)
    assert a.load(strict=True)[1].ignored == []
    a.drive(joint, "X", damping=1.0)
    assert "revolute joint has no drive" in _of(a.load()[1], "/Robot/j")["drive:X"]


def test_the_second_physics_scene_is_reported(author):
    a = author()
    a.body("/Robot/a")
    for name, gravity in (("one", 1.0), ("two", 2.0)):
        UsdPhysics.Scene.Define(a.stage, f"/{name}").CreateGravityMagnitudeAttr(gravity)
    model, report = a.load()
    assert model.opt.gravity[2] == pytest.approx(-1.0)
    assert "</one> holds" in _of(report, "/two")[""]


def test_a_material_may_state_a_density_without_mass_api(author):
    a = author()
    a.body("/Robot/a", mass=None)
    a.bind(a.gprim("/Robot/a/box", "Cube", size=1.0), a.material("/Robot/m", density=7.0))
    model, report = a.load(strict=True)
    assert model.body("a").mass[0] == pytest.approx(7.0)
    assert report.ignored == []


# Which bodies nothing can touch.


def _arm(a, collider: str):
    """Base fixed to the world, a link that turns, a tool welded to it; a collider on the body named."""
    for i, name in enumerate(("base", "link", "tool")):
        a.body(f"/Robot/{name}", pos=(i, 0, 0))
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/base")
    a.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", pos0=(1, 0, 0))
    a.joint("/Robot/t", "FixedJoint", "/Robot/link", "/Robot/tool", pos0=(1, 0, 0))
    if collider:
        a.gprim(f"/Robot/{collider}/box", "Cube", size=0.1)
    return a


@pytest.mark.parametrize(
    ("collider", "shape", "expected"),
    [
        ("", "", ["link"]),
        ("tool", "link", []),  # welded: they move as one
        ("link", "tool", []),
        ("base", "link", ["link"]),
        ("base", "", []),  # a frame without any shape, beside a body with colliders
    ],
)
def test_bodies_that_nothing_can_touch_are_named(author, collider, shape, expected):
    a = _arm(author(), collider)
    if shape:
        a.gprim(f"/Robot/{shape}/picture", "Cube", collider=False, size=0.1)
    report = a.load(strict=True)[1]
    assert report.without_collider == expected
    assert len(report.summary()) == len(expected)
    if expected:
        assert "without a collider" in report.summary()[0]


@pytest.mark.parametrize("kinematic", [False, True])
def test_a_body_of_pictures_alone_is_named_unless_its_collider_is_switched_off(author, kinematic):
    a = author()
    a.attrs(a.body("/Robot/box"), {"physics:kinematicEnabled": kinematic})
    shape = a.gprim("/Robot/box/picture", "Cube", collider=False, size=0.1)
    assert a.load()[1].without_collider == ["box"]
    UsdPhysics.CollisionAPI.Apply(shape).CreateCollisionEnabledAttr(False)
    assert a.load()[1].without_collider == []


def test_the_summary_has_one_line_a_kind_with_the_number_of_prims(author):
    a = author()
    for i in range(3):
        body = a.body(f"/Robot/b{i}", inertia=(1, 1, 2.1 + i))
        a.gprim(f"/Robot/b{i}/box", "Cube", size=0.1)
        joint = a.joint(f"/Robot/j{i}", "SphericalJoint", None, f"/Robot/b{i}")
        a.attrs(joint, {f"physxLimit:rot{'XYZ'[i]}:stiffness": 5.0})
        a.attrs(body, {"physxRigidBody:linearDamping": 1.0, "physxRigidBody:sleepThreshold": 0.1}, "PhysxRigidBodyAPI")
    a.attrs("/Robot/b1", {"physics:velocity": Gf.Vec3f(1, 0, 0)})
    lines = a.load()[1].summary()
    assert len(lines) == 4  # the sleep threshold is another engine's tuning
    (limits,) = [line for line in lines if "physxLimit" in line]
    assert limits.startswith("ignored physxLimit:*:stiffness on 3 prims, the first </Robot/j0>: ")
    lines.remove(limits)
    assert lines[0].startswith("ignored physxRigidBody:linearDamping on 3 prims, the first </Robot/b0>: ")
    assert lines[1].startswith("ignored physics:velocity on </Robot/b1>: ")
    assert lines[2].startswith("approximated physics:diagonalInertia on 3 prims, the first </Robot/b0>: ")
