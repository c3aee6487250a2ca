"""Features of physics in USD, each as a small stage and the numbers that any importer should find in it.

The numbers follow from the UsdPhysics specification (degrees, stage units, mass precedence) and closed forms, not from
an importer. A path such as ``joints.j.limits`` leads into the answers of usd_compare_run.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

D = math.pi / 180


@dataclass
class Feature:
    """One row of the table: a stage and what must be found in it."""

    name: str
    stage: str
    expected: dict[str, Any]
    tolerance: float = 1e-4


def stage(content: str, up: str = "Z", metres: float = 1.0, kilograms: float = 1.0, schemas: str = "") -> str:
    """A stage whose default prim is /R."""
    applied = f' (prepend apiSchemas = ["{schemas}"])' if schemas else ""
    units = f"metersPerUnit = {metres}\nkilogramsPerUnit = {kilograms}"
    return (
        f'#usda 1.0\n(\ndefaultPrim = "R"\nupAxis = "{up}"\n{units}\n)\n'
        f'def PhysicsScene "Scene" {{}}\ndef Xform "R"{applied} {{\n{content}\n}}\n'
    )


def _schemas(*names: str) -> str:
    return f"(prepend apiSchemas = [{', '.join(repr(n) for n in names if n)}])".replace("'", '"')


def body(name: str, pos=(0, 0, 0), inner: str = "", mass: str | None = None, schemas: str = "", attrs: str = "") -> str:
    """A rigid body of 2 kg with moments 0.1, 0.2, 0.25 kg m^2 unless `mass` authors something else."""
    if mass is None:
        mass = "float physics:mass = 2 float3 physics:diagonalInertia = (0.1, 0.2, 0.25)"
    mass = mass.replace(" float", "\nfloat").replace(" point", "\npoint").replace(" quat", "\nquat")
    names = _schemas("PhysicsRigidBodyAPI", "PhysicsMassAPI", *schemas.split())
    return (
        f'def Xform "{name}" {names} {{\n{mass}\n{attrs}\ndouble3 xformOp:translate = {tuple(pos)}\n'
        f'uniform token[] xformOpOrder = ["xformOp:translate"]\n{inner}\n}}\n'
    )


def shape(name: str, kind="Cube", attrs="double size = 0.2", schemas="", solid=True) -> str:
    """A geometric prim, a collider unless told otherwise."""
    names = _schemas("PhysicsCollisionAPI" if solid else "", *schemas.split())
    return f'def {kind} "{name}" {names if solid or schemas else ""} {{\n{attrs}\n}}\n'


def joint(kind: str, name: str, body0: str | None, body1: str, attrs: str = "", schemas: str = "") -> str:
    """A joint prim between children of /R."""
    first = f"rel physics:body0 = </R/{body0}>\n" if body0 else ""
    names = _schemas(*schemas.split()) if schemas else ""
    return f'def Physics{kind}Joint "{name}" {names} {{\n{first}rel physics:body1 = </R/{body1}>\n{attrs}\n}}\n'


BASE = body("A", schemas="PhysicsArticulationRootAPI")
HELD = joint("Fixed", "held", None, "A")
AXIS = 'uniform token physics:axis = "Z"\n'
DRIVE = "PhysicsDriveAPI:angular"


def arm(attrs: str = "", schemas: str = "", kind: str = "Revolute", second: str = "", held: str = HELD) -> str:
    """A held to the world, B turning or sliding on it along z."""
    parts = (BASE if held else body("A")) + body("B", (0, 0, 1)) + held
    frame = AXIS + "point3f physics:localPos0 = (0, 0, 1)\n"
    return parts + joint(kind, "j", "A", "B", frame + attrs, schemas) + second


def drive(token: str, **values: Any) -> str:
    """Attributes of a DriveAPI."""
    types = {"type": "uniform token"}
    lines = []
    for key, value in values.items():
        text = f'"{value}"' if isinstance(value, str) else value
        lines.append(f"{types.get(key, 'float')} drive:{token}:physics:{key} = {text}\n")
    return "".join(lines)


_CUBE = """point3f[] points = [(0,0,0),(1,0,0),(1,1,0),(0,1,0),(0,0,1),(1,0,1),(1,1,1),(0,1,1)]
int[] faceVertexCounts = [4,4,4,4,4,4]
int[] faceVertexIndices = [0,3,2,1,4,5,6,7,0,1,5,4,1,2,6,5,2,3,7,6,3,0,4,7]
float3 xformOp:scale = (-0.1, 0.1, 0.1)
uniform token[] xformOpOrder = ["xformOp:scale"]
"""
_MATERIAL = """def Material "M" (prepend apiSchemas = ["PhysicsMaterialAPI"]) {{
{}
}}
"""
_BOUND = "MaterialBindingAPI"
_BINDING = "rel material:binding:physics = </R/M>\n"
_TWO = body("A", (0, 0, 0), shape("a")) + body("B", (3, 0, 0), shape("b")) + body("C", (6, 0, 0), shape("c"))

FEATURES = [
    Feature("limits of revolute joints", stage(arm("float physics:lowerLimit = -30\nfloat physics:upperLimit = 90\n")),
            {"joints.j.kind": "hinge", "joints.j.limits": [-30 * D, 90 * D]}),
    Feature("limits of prismatic joints",
            stage(arm("float physics:lowerLimit = -0.1\nfloat physics:upperLimit = 0.4\n", kind="Prismatic")),
            {"joints.j.kind": "slide", "joints.j.limits": [-0.1, 0.4]}),
    Feature("DriveAPI gains (per degree)", stage(arm(drive("angular", stiffness=2.0, damping=0.5), DRIVE)),
            {"joints.j.kp": 2 / D, "joints.j.kv": 0.5 / D}),
    Feature("DriveAPI maxForce", stage(arm(drive("angular", stiffness=2.0, damping=0.5, maxForce=12.0), DRIVE)),
            {"joints.j.effort": 12.0}),
    Feature("acceleration drives",  # gains multiply the inertia of B about the joint, 0.25 kg m^2
            stage(arm(drive("angular", stiffness=2.0, damping=0.5, type="acceleration"), DRIVE)),
            {"joints.j.kp": 2 / D * 0.25, "joints.j.kv": 0.5 / D * 0.25}),
    Feature("spherical joints", stage(arm(kind="Spherical")), {"bodies.B.dofs": 3, "bodies.B.parent": "A"}),
    Feature("D6 joints",  # two of six axes are not locked
            stage(BASE + body("B") + HELD + joint("", "j", "A", "B", "".join(
                f"float limit:{t}:physics:low = 1\nfloat limit:{t}:physics:high = -1\n"
                for t in ("transX", "transY", "transZ", "rotX")),
                " ".join(f"PhysicsLimitAPI:{t}" for t in ("transX", "transY", "transZ", "rotX")))),
            {"bodies.B.dofs": 2, "bodies.B.parent": "A"}),
    Feature("several joints between two bodies",
            stage(arm(second=joint("Revolute", "k", "A", "B",
                                   'uniform token physics:axis = "X"\npoint3f physics:localPos0 = (0, 0, 1)\n'))),
            {"bodies.B.dofs": 2}),
    Feature("joints authored child first",
            stage(BASE + body("B") + HELD
                  + joint("Revolute", "j", "B", "A",
                          AXIS + "float physics:lowerLimit = -30\nfloat physics:upperLimit = 90\n")),
            {"bodies.B.parent": "A", "bodies.B.dofs": 1, "joints.j.limits": [-30 * D, 90 * D]}),
    Feature("loops of joints",
            stage(BASE + body("B") + body("C") + HELD + joint("Revolute", "j", "A", "B", AXIS)
                  + joint("Revolute", "k", "B", "C", AXIS) + joint("Revolute", "l", "C", "A", AXIS)),
            {"loops": True, "bodies.B.dofs": 1}),
    Feature("excludeFromArticulation",
            stage(arm(second=body("C") + joint("Fixed", "c", "A", "C")
                      + joint("Spherical", "l", "B", "C", "uniform bool physics:excludeFromArticulation = 1"))),
            {"loops": True, "bodies.C.parent": "A"}),
    Feature("free bodies; the articulation's root on an Xform",
            stage(arm(held=""), schemas="PhysicsArticulationRootAPI"),
            {"free": ["A"], "bodies.B.dofs": 1, "bodies.B.parent": "A"}),
    Feature("fixed joints keep their bodies", stage(BASE + body("B") + HELD + joint("Fixed", "f", "A", "B")),
            {"bodies.A.mass": 2.0, "bodies.B.mass": 2.0, "bodies.B.parent": "A"}),
    Feature("armature and speed limits of PhysX",
            stage(arm("float physxJoint:armature = 0.3\nfloat physxJoint:maxJointVelocity = 90\n", "PhysxJointAPI")),
            {"joints.j.armature": 0.3, "joints.j.speed": 90 * D}),
    Feature("armature, friction and damping of Newton",
            stage(arm("float newton:armature = 0.3\nfloat newton:friction = 0.2\nfloat newton:damping = 0.01\n",
                      "NewtonJointAPI")),
            {"joints.j.armature": 0.3, "joints.j.friction": 0.2, "joints.j.damping": 0.01 / D}),
    Feature("armature and friction of MuJoCo's schema",
            stage(arm("double mjc:armature = 0.3\ndouble mjc:frictionloss = 0.2\n", "MjcJointAPI")),
            {"joints.j.armature": 0.3, "joints.j.friction": 0.2}),
    Feature("mimic joints of PhysX",  # q + gearing q_k + offset = 0
            stage(arm("float physxMimicJoint:rotZ:gearing = -2\nfloat physxMimicJoint:rotZ:offset = 0\n"
                      "rel physxMimicJoint:rotZ:referenceJoint = </R/k>\n", "PhysxMimicJointAPI:rotZ",
                      second=body("C") + joint("Revolute", "k", "A", "C", AXIS))),
            {"mimics.j": [0.0, 2.0]}),
    Feature("mimic joints of Newton",
            stage(arm("float newton:mimicCoef1 = 2\nrel newton:mimicJoint = </R/k>\n", "NewtonMimicAPI",
                      second=body("C") + joint("Revolute", "k", "A", "C", AXIS))),
            {"mimics.j": [0.0, 2.0]}),
    Feature("mass without inertia",  # a cube of 0.2 m and 3 kg: m a^2 / 6
            stage(body("A", inner=shape("a"), mass="float physics:mass = 3")),
            {"bodies.A.mass": 3.0, "bodies.A.inertia": [0.02] * 3}),
    Feature("density of bodies and materials",
            stage(_MATERIAL.format("float physics:density = 500")
                  + body("A", inner=shape("a", attrs="double size = 0.2\n" + _BINDING, schemas=_BOUND), mass="")
                  + body("B", (3, 0, 0), inner=shape("b"), mass="float physics:density = 250")),
            {"bodies.A.mass": 4.0, "bodies.B.mass": 2.0}),
    Feature("centre of mass and principal axes",  # a quarter turn about x swaps the moments of y and z
            stage(body("A", mass="float physics:mass = 2 float3 physics:diagonalInertia = (0.1, 0.2, 0.25) "
                                 "point3f physics:centerOfMass = (0.1, 0, 0.2) "
                                 "quatf physics:principalAxes = (0.70710678, 0.70710678, 0, 0)")),
            {"bodies.A.com": [0.1, 0, 0.2], "bodies.A.inertia": [0.1, 0.2, 0.25]}),
    Feature("full inertia of Newton",
            stage(body("A", mass="float physics:mass = 2", schemas="NewtonMassAPI",
                       attrs="double[] newton:inertia = [0.2, 0.2, 0.3, 0.1, 0, 0]")),
            {"bodies.A.inertia": [0.1, 0.3, 0.3]}),
    Feature("stages in centimetres",
            stage(body("A", (0, 0, 100), shape("a", attrs="double size = 20"), mass="float physics:density = 0.0005"),
                  metres=0.01),
            {"bodies.A.pos": [0, 0, 1.0], "shapes.a.size": [0.1] * 3, "gravity": [0, 0, -9.81]}, 2e-3),
    Feature("Y-up stages", stage(body("A", (0, 2, 1), shape("a")), up="Y"),
            {"bodies.A.pos": [0, -1, 2], "gravity": [0, 0, -9.81]}, 2e-3),
    Feature("stages in grams", stage(body("A", mass="float physics:mass = 2000"), kilograms=0.001),
            {"bodies.A.mass": 2.0}),
    Feature("shapes scaled unevenly",
            stage(body("A", inner=shape("a", "Sphere", "double radius = 1\nfloat3 xformOp:scale = (0.1, 0.2, 0.3)\n"
                                        'uniform token[] xformOpOrder = ["xformOp:scale"]'))),
            {"shapes.a.kind": "ellipsoid", "shapes.a.size": [0.1, 0.2, 0.3]}),
    Feature("mirrored meshes",  # a cube of 0.1 m and 1000 kg/m^3, its corner at the origin
            stage(body("A", inner=shape("a", "Mesh", _CUBE, "PhysicsMeshCollisionAPI"), mass="")),
            {"bodies.A.mass": 1.0, "bodies.A.com": [-0.05, 0.05, 0.05]}, 1e-3),
    Feature("friction of materials",
            stage(_MATERIAL.format("float physics:dynamicFriction = 0.7\nfloat physics:staticFriction = 0.9")
                  + body("A", inner=shape("a", attrs="double size = 0.2\n" + _BINDING, schemas=_BOUND))),
            {"shapes.a.friction.0": 0.7}),
    Feature("collision groups",
            stage(_TWO + 'def PhysicsCollisionGroup "G" (prepend apiSchemas = ["CollectionAPI:colliders"]) {\n'
                  "rel collection:colliders:includes = [</R/A>, </R/B>]\nrel physics:filteredGroups = </R/G>\n}\n"),
            {"colliding": ["A-C", "B-C"]}),
    Feature("filtered pairs",
            stage(body("A", inner=shape("a"), schemas="PhysicsFilteredPairsAPI",
                       attrs="rel physics:filteredPairs = </R/B>")
                  + body("B", (3, 0, 0), shape("b")) + body("C", (6, 0, 0), shape("c"))),
            {"colliding": ["A-C", "B-C"]}),
    Feature("self-collision switch of PhysX",
            stage(body("A", inner=shape("a")) + body("B", (0, 0, 1), shape("b")) + body("C", (0, 0, 2), shape("c"))
                  + joint("Revolute", "j", "A", "B", AXIS) + joint("Revolute", "k", "B", "C", AXIS)
                  + "bool physxArticulation:enabledSelfCollisions = 0\n",
                  schemas='PhysicsArticulationRootAPI", "PhysxArticulationAPI'),
            {"colliding": []}),
    Feature("visual shapes", stage(body("A", inner=shape("a", "Sphere", "double radius = 0.1", solid=False))),
            {"shapes.a.solid": False, "bodies.A.mass": 2.0}),
    Feature("kinematic bodies", stage(body("A", (0, 0, 1), shape("a"), attrs="bool physics:kinematicEnabled = 1")),
            {"bodies.A.driven": True}),
    Feature("bodies without gravity",
            stage(body("A", attrs="bool physxRigidBody:disableGravity = 1", schemas="PhysxRigidBodyAPI")),
            {"bodies.A.weightless": True}),
    Feature("instanced prims",
            stage('class Xform "Proto" {\n' + shape("a") + "}\n"
                  + body("A", inner='def "look" (instanceable = true\nprepend references = </R/Proto>) {}')),
            {"shapes.a.size": [0.1] * 3, "bodies.A.mass": 2.0}),
    Feature("point instancers of rigid bodies",
            stage('def PointInstancer "I" {\nrel prototypes = [</R/I/P>]\nint[] protoIndices = [0, 0, 0]\n'
                  "point3f[] positions = [(0, 0, 0), (1, 0, 0), (2, 0, 0)]\n" + body("P", inner=shape("a")) + "}\n"),
            {"free.length": 3}),
    Feature("actuators and tendons of MuJoCo's schema",
            stage(arm(second='def MjcActuator "m" {\nrel mjc:target = </R/j>\n}\n'
                             'def MjcTendon "t" {\nuniform token mjc:type = "fixed"\nrel mjc:path = [</R/j>]\n'
                             "double[] mjc:path:coef = [1]\n}\n")),
            {"actuators": 1, "tendons": 1}),
    Feature("sites of MuJoCo's schema", stage(body("A", inner=shape("s", "Sphere", "double radius = 0.01",
                                                                    "MjcSiteAPI", solid=False))),
            {"sites": 1}),
    Feature("cameras", stage(body("A", inner='def Camera "c" {}')), {"cameras": 1}),
]  # fmt: skip
