"""A small arm as Isaac Sim would author it against an MJCF of the same numbers."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics
from scipy.spatial.transform import Rotation

DEG = math.pi / 180
LINKS = {
    "link0": (2.0, (0.01, 0.02, 0.05), (0.02, 0.03, 0.025)),
    "link1": (3.0, (0.0, -0.03, 0.1), (0.05, 0.04, 0.02)),
    "link2": (1.5, (0.1, 0.0, 0.02), (0.01, 0.03, 0.035)),
    "finger": (0.2, (0.0, 0.01, 0.0), (1e-4, 2e-4, 1.5e-4)),
}
AXES = {name: Rotation.from_euler("xyz", (7 * i, -11 * i, 5 * i), degrees=True) for i, name in enumerate(LINKS)}
# parent, kind, local frame 0 (position, rotation about x in degrees), limits (rad or m), kp, kv, effort
JOINTS = {
    "joint1": ("link0", "link1", "RevoluteJoint", (0, 0, 0.3), 0, (-2.8, 2.5), 400.0, 80.0, 87.0),
    "joint2": ("link1", "link2", "RevoluteJoint", (0.05, 0, 0.2), -90, (-1.7, 1.6), 300.0, 60.0, 40.0),
    "finger_joint": ("link2", "finger", "PrismaticJoint", (0.2, 0, 0), 90, (0.0, 0.04), 2000.0, 100.0, 70.0),
}
MJCF = """
<mujoco><compiler angle="radian"/><worldbody><body name="link0"><inertial {link0}/>
 <body name="link1" pos="0 0 .3"><inertial {link1}/>
  <joint name="joint1" axis="0 0 1" range="-2.8 2.5" armature=".1" actuatorfrcrange="-87 87"/>
  <geom type="capsule" size=".05 .1" pos="0 0 .1"/>
  <body name="link2" pos=".05 0 .2" euler="-1.5707963267948966 0 0"><inertial {link2}/>
   <joint name="joint2" axis="0 0 1" range="-1.7 1.6" armature=".05" actuatorfrcrange="-40 40"/>
   <body name="finger" pos=".2 0 0" euler="1.5707963267948966 0 0"><inertial {finger}/>
    <joint name="finger_joint" type="slide" axis="0 0 1" range="0 .04" armature=".01"
     actuatorfrcrange="-70 70"/></body></body></body></body>
</worldbody><actuator>
 <position joint="joint1" kp="400" kv="80"/><position joint="joint2" kp="300" kv="60"/>
 <position joint="finger_joint" kp="2000" kv="100"/></actuator></mujoco>
"""


def _quat(rotation):
    return np.roll(rotation.as_quat(), 1)


@pytest.fixture(scope="module")
def twin():
    """MuJoCo's own compile of the same numbers."""
    inertials = {
        name: f'mass="{mass}" pos="{" ".join(map(str, com))}" diaginertia="{" ".join(map(str, inertia))}"'
        f' quat="{" ".join(map(str, _quat(AXES[name])))}"'
        for name, (mass, com, inertia) in LINKS.items()
    }
    return mujoco.MjModel.from_xml_string(MJCF.format(**inertials))


@pytest.fixture
def arm(author):
    """Root API on the Xform, a joint prim under each parent link, drives per degree, PhysX schemas."""
    a = author()
    robot = a.stage.GetPrimAtPath("/Robot")
    UsdPhysics.ArticulationRootAPI.Apply(robot)
    a.attrs(robot, {"physxArticulation:enabledSelfCollisions": False}, "PhysxArticulationAPI")
    worlds = {"link0": (np.zeros(3), Rotation.identity())}
    for parent, child, _, pos, turn, *_ in JOINTS.values():
        origin, rot = worlds[parent]
        worlds[child] = (origin + rot.apply(pos), rot * Rotation.from_euler("x", turn, degrees=True))
    for name, (mass, com, inertia) in LINKS.items():
        prim = a.body(f"/Robot/{name}", worlds[name][0], _quat(worlds[name][1]), None, mass, inertia, com)
        a.mass(prim, principalAxes=Gf.Quatf(*map(float, _quat(AXES[name]))))
    a.joint("/Robot/root_joint", "FixedJoint", None, "/Robot/link0")
    for name, (parent, child, kind, pos, turn, limits, kp, kv, effort) in JOINTS.items():
        angular = kind == "RevoluteJoint"
        unit = DEG if angular else 1.0
        joint = a.joint(
            f"/Robot/{parent}/{name}", kind, f"/Robot/{parent}", f"/Robot/{child}", "Z", pos,
            _quat(Rotation.from_euler("x", turn, degrees=True)), limits=[v / unit for v in limits],
        )  # fmt: skip
        a.drive(joint, "angular" if angular else "linear", stiffness=kp * unit, damping=kv * unit, maxForce=effort)
        armature = {"joint1": 0.1, "joint2": 0.05, "finger_joint": 0.01}[name]
        a.attrs(joint, {"physxJoint:armature": armature, "physxJoint:maxJointVelocity": 2.0 / unit}, "PhysxJointAPI")
    capsule = a.gprim("/Robot/link1/collisions", "Capsule", pos=(0, 0, 0.1), radius=0.05, height=0.2)
    UsdGeom.Imageable(capsule).CreatePurposeAttr("guide")
    return a


STATES = [
    np.zeros(3), np.array([0.4, -0.9, 0.02]), np.array([-2.1, 1.3, 0.04]), np.array([1.7, 0.2, 0.0]),
]  # fmt: skip


@pytest.mark.parametrize("q", STATES)
def test_kinematics_mass_matrix_and_gravity_agree_with_the_mjcf(arm, twin, q):
    model, _ = arm.load()
    results = []
    for m in (model, twin):
        data = mujoco.MjData(m)
        data.qpos[:] = q
        mujoco.mj_forward(m, data)
        mass = np.zeros((m.nv, m.nv))
        mujoco.mj_fullM(m, data, mass)
        results.append((data.xpos.copy(), data.xmat.copy(), mass, data.qfrc_bias.copy()))
    for ours, theirs in zip(*results, strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-6)


def test_drives_limits_and_efforts_agree_with_the_mjcf(arm, twin):
    model, report = arm.load()
    np.testing.assert_allclose(model.actuator_gainprm, twin.actuator_gainprm, rtol=1e-6)
    np.testing.assert_allclose(model.actuator_biasprm, twin.actuator_biasprm, rtol=1e-6)
    np.testing.assert_allclose(model.jnt_range, twin.jnt_range, atol=1e-6)
    np.testing.assert_allclose(model.jnt_actfrcrange[:, 1], (87, 40, 70))
    assert report.joint_velocity_limits == pytest.approx({"joint1": 2.0, "joint2": 2.0, "finger_joint": 2.0})
    assert report.articulation_roots == ["/Robot"]


def test_names_and_order_are_those_of_the_prims(arm):
    _, report = arm.load()
    assert report.bodies == list(LINKS)
    assert report.joints == report.actuators == list(JOINTS)
    assert report.root_bodies == ["link0"]


def test_a_second_of_simulation_agrees_with_the_mjcf(arm, twin):
    model, _ = arm.load()
    twin.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    ends = []
    for m in (model, twin):
        data = mujoco.MjData(m)
        data.ctrl[:] = (0.5, -0.7, 0.03)
        for _ in range(500):
            mujoco.mj_step(m, data)
        ends.append(data.qpos.copy())
    np.testing.assert_allclose(*ends, atol=1e-5)


def test_the_written_mjcf_reads_back_as_the_same_model(arm):
    from lift_lab.usd import load

    spec, _ = load(arm.stage)
    model = spec.compile()
    again = mujoco.MjModel.from_xml_string(spec.to_xml())
    np.testing.assert_allclose(again.body_inertia, model.body_inertia, rtol=1e-4)
    np.testing.assert_allclose(again.jnt_range, model.jnt_range, rtol=1e-4)
    assert again.nexclude == model.nexclude == 6
