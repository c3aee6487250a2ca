"""A Franka as Isaac Sim's assets are layered: instanceable parts, a physics variant in a payload, a scene around it.

The numbers are franka_description's; expectations come from the product of its transforms, not from the importer.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lift_lab.usd import load

DEG = math.pi / 180
# xyz, rotation about x (rad), limits (rad), velocity (rad/s), effort (N m)
ARM = [
    ((0, 0, 0.333), 0.0, (-2.8973, 2.8973), 2.175, 87.0),
    ((0, 0, 0), -math.pi / 2, (-1.7628, 1.7628), 2.175, 87.0),
    ((0, -0.316, 0), math.pi / 2, (-2.8973, 2.8973), 2.175, 87.0),
    ((0.0825, 0, 0), math.pi / 2, (-3.0718, -0.0698), 2.175, 87.0),
    ((-0.0825, 0.384, 0), -math.pi / 2, (-2.8973, 2.8973), 2.61, 12.0),
    ((0, 0, 0), math.pi / 2, (-0.0175, 3.7525), 2.61, 12.0),
    ((0.088, 0, 0), math.pi / 2, (-2.8973, 2.8973), 2.61, 12.0),
]
MASSES = [0.629769, 4.970684, 0.646926, 3.228604, 3.587895, 1.225946, 1.666555, 0.735522, 0.73, 0.015, 0.015]
LINKS = [*(f"panda_link{i}" for i in range(8)), "panda_hand", "panda_leftfinger", "panda_rightfinger"]
HAND = ((0, 0, 0.107), Rotation.from_euler("z", -math.pi / 4))
READY = [0.0, -0.569, 0.0, -2.81, 0.0, 3.037, 0.741]

HEADER = '#usda 1.0\n(\n    defaultPrim = "{}"\n    metersPerUnit = 1\n    upAxis = "Z"\n)\n'


def _transform(pos, rotation):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation.as_matrix(), pos
    return matrix


def _chain(q):
    """World transforms of link0..link7 and the hand for joint angles q, base at the origin."""
    poses = [np.eye(4)]
    for (pos, rx, *_), angle in zip(ARM, q, strict=True):
        turn = Rotation.from_euler("x", rx) * Rotation.from_euler("z", angle)
        poses.append(poses[-1] @ _transform(pos, turn))
    return [*poses, poses[-1] @ _transform(*HAND)]


def _quat(rotation):
    x, y, z, w = rotation.as_quat()
    return f"({w:.9g}, {x:.9g}, {y:.9g}, {z:.9g})"


def _joint(kind, name, body0, body1, pos, rotation, extra="", schemas=()):
    applied = ", ".join(f'"{s}"' for s in schemas)
    metadata = f"(prepend apiSchemas = [{applied}])" if schemas else ""
    return f"""
    def {kind} "{name}" {metadata}
    {{
        rel physics:body0 = </panda/{body0}>
        rel physics:body1 = </panda/{body1}>
        point3f physics:localPos0 = {tuple(float(v) for v in pos)}
        quatf physics:localRot0 = {_quat(rotation)}
        point3f physics:localPos1 = (0, 0, 0)
        quatf physics:localRot1 = (1, 0, 0, 0)
        {extra}
    }}"""


def _author(folder):
    """parts.usda <- panda_base.usda <- (payload) panda_physx.usda <- panda.usda <- scene.usda."""
    start = _chain([0.1, *READY[1:]])  # authored poses: not the zero pose
    (folder / "parts.usda").write_text(
        HEADER.format("parts")
        + """
def Scope "parts"
{
    def Xform "shell"
    {
        def Mesh "shell"
        {
            point3f[] points = [(0, 0, 0), (0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.05)]
            int[] faceVertexCounts = [3, 3, 3, 3]
            int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]
            color3f[] primvars:displayColor = [(1, 1, 1)]
        }
    }
    def Xform "hull"
    {
        def Mesh "hull" (
            prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI", "PhysxConvexHullCollisionAPI"]
        )
        {
            point3f[] points = [(0, 0, 0), (0.05, 0, 0), (0, 0.05, 0), (0, 0, 0.05)]
            int[] faceVertexCounts = [3, 3, 3, 3]
            int[] faceVertexIndices = [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]
            uniform token physics:approximation = "convexHull"
            int physxConvexHullCollision:hullVertexLimit = 64
            uniform token purpose = "guide"
        }
    }
}
"""
    )
    base = ""
    poses = [*start, start[8] @ _transform((0, 0.02, 0.0584), Rotation.identity())]
    poses.append(start[8] @ _transform((0, -0.01, 0.0584), Rotation.from_euler("z", math.pi)))
    for name, pose in zip(LINKS, poses, strict=True):
        quat = _quat(Rotation.from_matrix(pose[:3, :3]))
        base += f"""
    def Xform "{name}"
    {{
        double3 xformOp:translate = {tuple(float(v) for v in pose[:3, 3])}
        quatd xformOp:orient = {quat}
        double3 xformOp:scale = (1, 1, 1)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient", "xformOp:scale"]
        def Xform "visuals" (instanceable = true
                             prepend references = @./parts.usda@</parts/shell>) {{}}
        def Xform "collisions" (instanceable = true
                                prepend references = @./parts.usda@</parts/hull>) {{}}
    }}"""
    (folder / "panda_base.usda").write_text(HEADER.format("panda") + f'def Xform "panda"\n{{{base}\n}}\n')

    physics = ""
    for name, mass in zip(LINKS, MASSES, strict=True):
        physics += f"""
    over "{name}" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI", "PhysxRigidBodyAPI"])
    {{
        float physics:mass = {mass}
        float3 physics:diagonalInertia = (0.01, 0.011, 0.012)
        bool physxRigidBody:disableGravity = 1
    }}"""
    physics += '\n    def PhysicsFixedJoint "root_joint" {\n        rel physics:body1 = </panda/panda_link0>\n    }'
    for i, (pos, rx, limits, velocity, effort) in enumerate(ARM):
        extra = f"""uniform token physics:axis = "Z"
        float physics:lowerLimit = {limits[0] / DEG}
        float physics:upperLimit = {limits[1] / DEG}
        float drive:angular:physics:stiffness = {400 * DEG}
        float drive:angular:physics:damping = {80 * DEG}
        float drive:angular:physics:maxForce = {effort}
        float drive:angular:physics:targetPosition = {READY[i] / DEG}
        uniform token drive:angular:physics:type = "force"
        float physxJoint:armature = 0.1
        float physxJoint:maxJointVelocity = {velocity / DEG}
        float state:angular:physics:position = {READY[i] / DEG}"""
        schemas = ("PhysicsDriveAPI:angular", "PhysxJointAPI", "PhysicsJointStateAPI:angular")
        turn = Rotation.from_euler("x", rx)
        physics += _joint(
            "PhysicsRevoluteJoint", f"panda_joint{i + 1}", LINKS[i], LINKS[i + 1], pos, turn, extra, schemas
        )
    physics += _joint("PhysicsFixedJoint", "panda_hand_joint", LINKS[7], LINKS[8], *HAND)
    for i, turn in enumerate((Rotation.identity(), Rotation.from_euler("z", math.pi))):
        extra = 'uniform token physics:axis = "Y"\n        float physics:lowerLimit = 0\n'
        extra += "        float physics:upperLimit = 0.04\n"
        schemas = ["PhysxJointAPI"]
        if i:
            schemas += ["PhysxMimicJointAPI:rotX"]
            extra += "        float physxMimicJoint:rotX:gearing = -1\n        float physxMimicJoint:rotX:offset = 0\n"
            extra += "        rel physxMimicJoint:rotX:referenceJoint = </panda/panda_finger_joint1>\n"
        else:
            schemas += ["PhysicsDriveAPI:linear"]
            for key, value in (("stiffness", 2000), ("damping", 100), ("maxForce", 200)):
                extra += f"        float drive:linear:physics:{key} = {value}\n"
        name = f"panda_finger_joint{i + 1}"
        physics += _joint("PhysicsPrismaticJoint", name, LINKS[8], LINKS[9 + i], (0, 0, 0.0584), turn, extra, schemas)
    articulation = '"PhysicsArticulationRootAPI", "PhysxArticulationAPI"'
    (folder / "panda_physx.usda").write_text(
        HEADER.format("panda") + f'over "panda" (prepend apiSchemas = [{articulation}])\n{{\n'
        f"    bool physxArticulation:enabledSelfCollisions = 0\n"
        f"    int physxArticulation:solverPositionIterationCount = 32\n{physics}\n}}\n"
    )
    (folder / "panda.usda").write_text(
        HEADER.format("panda")
        + """
def Xform "panda" (
    prepend references = @./panda_base.usda@
    variants = { string Physics = "None" }
    prepend variantSets = "Physics"
)
{
    variantSet "Physics" = {
        "None" {}
        "PhysX" (prepend payload = @./panda_physx.usda@) {}
    }
}
"""
    )
    (folder / "scene.usda").write_text(
        HEADER.format("World")
        + f"""
def Xform "World"
{{
    def PhysicsScene "PhysicsScene" (prepend apiSchemas = ["PhysxSceneAPI"])
    {{
        vector3f physics:gravityDirection = (0, 0, -1)
        float physics:gravityMagnitude = 9.81
        uint physxScene:timeStepsPerSecond = 120
    }}
    def Plane "GroundPlane" (prepend apiSchemas = ["PhysicsCollisionAPI"])
    {{
        uniform token axis = "Z"
    }}
    def Cube "Pedestal" (prepend apiSchemas = ["PhysicsCollisionAPI"])
    {{
        double size = 0.4
        double3 xformOp:translate = (1, 2, 0.2)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }}
    def Xform "Franka" (
        prepend references = @./panda.usda@
        variants = {{ string Physics = "PhysX" }}
    )
    {{
        double3 xformOp:translate = (1, 2, 0.4)
        quatd xformOp:orient = {_quat(Rotation.from_euler("z", 90, degrees=True))}
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:orient"]
        over "root_joint"
        {{
            bool physics:jointEnabled = 0
        }}
    }}
    def PhysicsFixedJoint "PedestalJoint"
    {{
        rel physics:body0 = </World/Pedestal>
        rel physics:body1 = </World/Franka/panda_link0>
        point3f physics:localPos0 = (0, 0, 0.2)
        quatf physics:localRot0 = {_quat(Rotation.from_euler("z", 90, degrees=True))}
    }}
}}
"""
    )
    return folder


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    return _author(tmp_path_factory.mktemp("isaac"))


@pytest.fixture(scope="module")
def panda(stage):
    spec, report = load(stage / "panda.usda", variants={"Physics": "PhysX"})
    return spec.compile(), report


def test_bodies_and_joints_have_isaac_sims_names_in_its_order(panda):
    _, report = panda
    assert report.bodies == LINKS
    assert report.joints == [*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1", "panda_finger_joint2"]
    assert report.articulation_roots == ["/panda"]


@pytest.mark.parametrize("q", [[0.0] * 7, READY, [1.1, -0.6, 0.4, -1.9, -2.0, 1.2, 2.2]])
def test_forward_kinematics_are_the_product_of_its_transforms(panda, q):
    model, _ = panda
    data = mujoco.MjData(model)
    for i, angle in enumerate(q):
        data.joint(f"panda_joint{i + 1}").qpos[0] = angle
    data.joint("panda_finger_joint1").qpos[0] = 0.03
    mujoco.mj_kinematics(model, data)
    for name, pose in zip(LINKS[:9], _chain(q), strict=True):
        np.testing.assert_allclose(data.body(name).xpos, pose[:3, 3], atol=2e-6)
        np.testing.assert_allclose(data.body(name).xmat.reshape(3, 3), pose[:3, :3], atol=2e-6)
    finger = _chain(q)[8] @ [0, 0.03, 0.0584, 1]
    np.testing.assert_allclose(data.body("panda_leftfinger").xpos, finger[:3], atol=2e-6)


def test_masses_gains_limits_and_efforts_are_authored_ones_in_si(panda):
    model, report = panda
    np.testing.assert_allclose(model.body_mass[1:], MASSES, rtol=1e-6)
    assert model.body_mass.sum() == pytest.approx(17.452, abs=1e-3)
    assert report.actuators == [*(f"panda_joint{i}" for i in range(1, 8)), "panda_finger_joint1"]
    np.testing.assert_allclose(model.actuator_gainprm[:, 0], [400] * 7 + [2000], rtol=1e-6)
    np.testing.assert_allclose(-model.actuator_biasprm[:, 2], [80] * 7 + [100], rtol=1e-6)
    for i, (_, _, limits, velocity, effort) in enumerate(ARM):
        joint = model.joint(f"panda_joint{i + 1}")
        np.testing.assert_allclose(joint.range, limits, rtol=1e-5)
        assert model.jnt_actfrcrange[joint.id][1] == pytest.approx(effort)
        assert model.dof_armature[joint.dofadr[0]] == pytest.approx(0.1)
        assert report.joint_velocity_limits[joint.name] == pytest.approx(velocity, rel=1e-5)
    assert model.body_gravcomp[1:].tolist() == [1.0] * 11


def test_the_authored_joint_state_and_targets_are_where_it_starts(panda):
    """The authored pose of joint 1 is 0.1 rad off, and loses."""
    _, report = panda
    moved = {f"panda_joint{i + 1}": angle for i, angle in enumerate(READY) if angle}
    arm = {name: value for name, value in report.initial_joint_pos.items() if "finger" not in name}
    assert arm == pytest.approx(moved, rel=1e-5)
    assert report.initial_joint_pos["panda_finger_joint1"] == pytest.approx(0.02, abs=1e-6)
    assert {n: v for n, v in report.initial_ctrl.items() if "finger" not in n} == pytest.approx(moved, rel=1e-5)


def test_the_second_finger_mimics_the_first_and_links_do_not_collide(panda):
    model, report = panda
    assert model.neq == 1
    np.testing.assert_allclose(model.eq_data[0, :2], (0.0, 1.0))
    assert report.dialects["mimic"] == {"physx": 1}
    assert model.nexclude == 11 * 10 // 2


def test_every_link_has_its_instanced_picture_and_hull(panda):
    model, _ = panda
    for name in LINKS:
        geoms = [g for g in range(model.ngeom) if model.geom_bodyid[g] == model.body(name).id]
        assert sorted(model.geom_group[geoms].tolist()) == [2, 3]
    assert model.nmesh == 2


def test_without_its_physics_variant_it_is_a_picture(stage):
    spec, report = load(stage / "panda.usda")
    model = spec.compile()
    assert (model.nv, model.nu, report.bodies) == (0, 0, ["panda"])


def test_in_a_scene_the_joint_of_the_world_mounts_it_on_its_pedestal(stage):
    spec, report = load(stage / "scene.usda")
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.body("panda_link0").xpos, (1, 2, 0.4), atol=1e-6)
    np.testing.assert_allclose(data.body("panda_link0").xmat.reshape(3, 3)[:, 0], (0, 1, 0), atol=1e-6)
    assert (model.nv, model.opt.timestep) == (9, pytest.approx(1 / 120))
    assert report.prim_paths["panda_hand"] == "/World/Franka/panda_hand"
    pairs = {frozenset((int(c.geom1), int(c.geom2))) for c in data.contact}
    assert not any(model.geom("Pedestal").id in pair for pair in pairs)


def test_nothing_physical_of_it_is_ignored(panda, stage):
    _, report = panda
    assert [note for note in report.ignored if not note.tuning] == []
    load(stage / "panda.usda", variants={"Physics": "PhysX"}, strict=True)
