"""Helpers to author physics in USD as Isaac Sim writes it. Owns the units and attribute names of the files we
ship.

UsdPhysics counts angles in degrees, so that stiffness and damping of an angular drive are per degree;
quaternions are wxyz. PhysX and MuJoCo attributes are written by name, since usd-core does not know their
schemas.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import degrees, radians

import numpy as np
from panda_description import Box, Capsule, Contact, Link
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdShade

Pose = tuple[np.ndarray, np.ndarray]
"""Position (3,) and rotation matrix (3, 3)."""


def rotation_from_rpy(rpy: Sequence[float]) -> np.ndarray:
    """Rotation matrix (3, 3) of roll, pitch, yaw in radians about fixed axes (URDF's convention)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    rx = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    rz = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return rz @ ry @ rx


def compose(a: Pose, b: Pose) -> Pose:
    """The pose of frame b, given in frame a, in the frame that a is given in."""
    return a[0] + a[1] @ b[0], a[1] @ b[1]


def quat_from_rotation(rotation: np.ndarray) -> np.ndarray:
    """Unit quaternion wxyz, w >= 0, of a rotation matrix (3, 3); components below 1e-12 are zero."""
    # The eigenvector of K's largest eigenvalue is the quaternion (Bar-Itzhack 2000): exact for any angle.
    m = rotation
    k = np.array(
        [
            [m[0, 0] - m[1, 1] - m[2, 2], 0, 0, 0],
            [m[1, 0] + m[0, 1], m[1, 1] - m[0, 0] - m[2, 2], 0, 0],
            [m[2, 0] + m[0, 2], m[2, 1] + m[1, 2], m[2, 2] - m[0, 0] - m[1, 1], 0],
            [m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], np.trace(m)],
        ]
    )
    x, y, z, w = np.linalg.eigh(k)[1][:, -1]
    quat = np.array([w, x, y, z])
    quat[np.abs(quat) < 1e-12] = 0.0
    leading = quat[np.flatnonzero(quat)[0]]
    return quat * np.sign(leading) / np.linalg.norm(quat) + 0.0  # + 0.0 turns -0 into 0


def box_inertia(mass: float, size: Sequence[float]) -> tuple[float, float, float, float, float, float]:
    """Inertia of a uniform box about its centre, kg m^2, in the order of `Link.inertia`."""
    x, y, z = size
    return (
        mass * (y * y + z * z) / 12,
        mass * (x * x + z * z) / 12,
        mass * (x * x + y * y) / 12,
        0.0,
        0.0,
        0.0,
    )


def link_of_boxes(mass: float, boxes: Sequence[Box]) -> Link:
    """A link whose mass (kg) is spread evenly over upright boxes; where two overlap, both count."""
    volumes = np.array([np.prod(box.size) for box in boxes])
    masses = mass * volumes / volumes.sum()
    centers = np.array([box.xyz for box in boxes])
    com = masses @ centers / mass
    total = np.zeros((3, 3))
    for part, box, arm in zip(masses, boxes, centers - com, strict=True):
        total += np.diag(box_inertia(float(part), box.size)[:3]) + part * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    xx, yy, zz, xy, xz, yz = _clean(total[(0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)])
    x, y, z = _clean(com)
    return Link(mass, (x, y, z), (xx, yy, zz, xy, xz, yz))


def principal_inertia(inertia: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Diagonalise an inertia tensor.

    Args:
        inertia: Ixx, Iyy, Izz, Ixy, Ixz, Iyz, kg m^2.

    Returns:
        The principal moments (3,) and the quaternion wxyz that turns principal axes into the link's frame.
    """
    xx, yy, zz, xy, xz, yz = inertia
    if xy == xz == yz == 0.0:
        return np.array([xx, yy, zz]), np.array([1.0, 0.0, 0.0, 0.0])
    moments, axes = np.linalg.eigh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))
    # An eigenvector's sign is arbitrary: make the largest component positive, and the frame right-handed.
    axes = axes * np.sign(axes[np.argmax(np.abs(axes), axis=0), range(3)])
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return moments, quat_from_rotation(axes)


def start_stage(layer: Sdf.Layer, default_prim: str, doc: str) -> tuple[Usd.Stage, Usd.Prim]:
    """Open a Z-up stage in metres and kilograms on an empty layer, with one default Xform."""
    stage = Usd.Stage.Open(layer)
    layer.documentation = doc
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdPhysics.SetStageKilogramsPerUnit(stage, 1.0)
    prim = UsdGeom.Xform.Define(stage, f"/{default_prim}").GetPrim()
    stage.SetDefaultPrim(prim)
    return stage, prim


def attribute(prim: Usd.Prim, name: str, kind: str, value: object) -> None:
    """Author an attribute of a schema that usd-core does not know, by name and Sdf type name."""
    prim.CreateAttribute(name, Sdf.ValueTypeNames.Find(kind), custom=False).Set(value)


def set_pose(prim: Usd.Prim, pose: Pose) -> None:
    """Give a prim a translate and an orient op, both in double precision."""
    xform = UsdGeom.Xformable(prim)
    xform.AddTranslateOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*_clean(pose[0])))
    xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(*quat_from_rotation(pose[1]).tolist()))


def define_link(stage: Usd.Stage, path: str, link: Link, pose: Pose) -> Usd.Prim:
    """A rigid body with explicit mass, centre of mass and principal inertia."""
    prim = UsdGeom.Xform.Define(stage, path).GetPrim()
    set_pose(prim, pose)
    UsdPhysics.RigidBodyAPI.Apply(prim)
    mass = UsdPhysics.MassAPI.Apply(prim)
    moments, axes = principal_inertia(link.inertia)
    mass.CreateMassAttr(link.mass)
    mass.CreateCenterOfMassAttr(Gf.Vec3f(*link.com))
    mass.CreateDiagonalInertiaAttr(Gf.Vec3f(*moments.tolist()))
    mass.CreatePrincipalAxesAttr(Gf.Quatf(*axes.tolist()))
    return prim


def set_articulation_root(prim: Usd.Prim) -> None:
    """Make a prim the root of an articulation whose links do not collide with each other."""
    UsdPhysics.ArticulationRootAPI.Apply(prim)
    prim.AddAppliedSchema("PhysxArticulationAPI")
    attribute(prim, "physxArticulation:enabledSelfCollisions", "bool", False)


def set_joint_frames(joint: UsdPhysics.Joint, parent: str, child: str, pose: Pose, turn: np.ndarray) -> None:
    """Connect two bodies. `pose` is the child in the parent at q = 0; `turn` (3, 3) the joint frame in the
    child."""
    if parent:
        joint.CreateBody0Rel().SetTargets([parent])
    joint.CreateBody1Rel().SetTargets([child])
    joint.CreateLocalPos0Attr(Gf.Vec3f(*_clean(pose[0])))
    joint.CreateLocalRot0Attr(Gf.Quatf(*quat_from_rotation(pose[1] @ turn).tolist()))
    joint.CreateLocalPos1Attr(Gf.Vec3f(0.0))
    joint.CreateLocalRot1Attr(Gf.Quatf(*quat_from_rotation(turn).tolist()))


def define_fixed_joint(stage: Usd.Stage, path: str, parent: str, child: str, pose: Pose) -> None:
    """A fixed joint; an empty `parent` is the world."""
    set_joint_frames(UsdPhysics.FixedJoint.Define(stage, path), parent, child, pose, np.eye(3))


def define_joint(
    stage: Usd.Stage,
    path: str,
    kind: str,
    *,
    parent: str,
    child: str,
    pose: Pose,
    axis: str,
    limits: tuple[float, float] | None,
    drive: tuple[float, float],
    effort: float,
    velocity: float,
    armature: float = 0.0,
    damping: float = 0.0,
) -> Usd.Prim:
    """A driven joint with its limits.

    Args:
        stage: The stage to write to.
        path: Prim path of the joint.
        kind: `revolute` or `prismatic`.
        parent: Path of body 0.
        child: Path of body 1.
        pose: The child's frame in the parent's at q = 0.
        axis: Axis of motion in the child's frame, `X`, `Y`, `Z`, or one of them after a minus sign.
        limits: Lower and upper limit, rad or m; None for none.
        drive: Stiffness and damping, per rad or per m.
        effort: Largest force of the drive, N m or N.
        velocity: Speed limit, rad/s or m/s.
        armature: Reflected inertia, kg m^2 or kg.
        damping: Passive viscous damping, N m s/rad or N s/m.
    """
    angular = kind == "revolute"
    joint = (UsdPhysics.RevoluteJoint if angular else UsdPhysics.PrismaticJoint).Define(stage, path)
    prim = joint.GetPrim()
    letter = axis[-1]
    turn = np.eye(3)
    if axis.startswith("-"):  # a half turn about another axis points the positive axis the other way
        turn = np.diag([1.0, -1.0, -1.0]) if letter == "Z" else np.diag([-1.0, -1.0, 1.0])
    set_joint_frames(joint, parent, child, pose, turn)
    joint.CreateAxisAttr(letter)
    if limits:
        joint.CreateLowerLimitAttr(degrees(limits[0]) if angular else limits[0])
        joint.CreateUpperLimitAttr(degrees(limits[1]) if angular else limits[1])
    usd_drive = UsdPhysics.DriveAPI.Apply(prim, "angular" if angular else "linear")
    per = radians(1.0) if angular else 1.0
    usd_drive.CreateTypeAttr("force")
    usd_drive.CreateMaxForceAttr(effort)
    usd_drive.CreateStiffnessAttr(drive[0] * per)
    usd_drive.CreateDampingAttr(drive[1] * per)
    prim.AddAppliedSchema("PhysxJointAPI")
    attribute(prim, "physxJoint:maxJointVelocity", "float", degrees(velocity) if angular else velocity)
    attribute(prim, "physxJoint:armature", "float", armature)
    if damping:
        prim.AddAppliedSchema("MjcJointAPI")
        attribute(prim, "mjc:damping", "double", damping)
    return prim


def define_material(stage: Usd.Stage, path: str, contact: Contact) -> UsdShade.Material:
    """A physics material with MuJoCo's torsional and rolling friction besides USD's sliding friction."""
    material = UsdShade.Material.Define(stage, path)
    physics = UsdPhysics.MaterialAPI.Apply(material.GetPrim())
    physics.CreateStaticFrictionAttr(contact.friction)
    physics.CreateDynamicFrictionAttr(contact.friction)
    physics.CreateRestitutionAttr(0.0)
    material.GetPrim().AddAppliedSchema("MjcMaterialAPI")
    attribute(material.GetPrim(), "mjc:torsionalfriction", "double", contact.torsional)
    attribute(material.GetPrim(), "mjc:rollingfriction", "double", contact.rolling)
    return material


def define_box(stage: Usd.Stage, path: str, box: Box, color: Sequence[float] | None = None) -> UsdGeom.Cube:
    """A box shape: a Cube of edge 1, scaled."""
    shape = UsdGeom.Cube.Define(stage, path)
    shape.CreateSizeAttr(1.0)
    shape.CreateExtentAttr([Gf.Vec3f(-0.5), Gf.Vec3f(0.5)])
    set_pose(shape.GetPrim(), (np.array(box.xyz), rotation_from_rpy(box.rpy)))
    shape.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*box.size))
    if color is not None:
        shape.CreateDisplayColorAttr([Gf.Vec3f(*color)])
    return shape


def define_box_mesh(stage: Usd.Stage, path: str, size: Sequence[float], color: Sequence[float]) -> UsdGeom.Mesh:
    """A box about its own origin as a mesh of eight points and six faces, counter-clockwise seen from outside."""
    mesh = UsdGeom.Mesh.Define(stage, path)
    corners = [np.array([x, y, z]) * size for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
    mesh.CreatePointsAttr([Gf.Vec3f(*corner.tolist()) for corner in corners])
    mesh.CreateExtentAttr([Gf.Vec3f(*corners[0].tolist()), Gf.Vec3f(*corners[-1].tolist())])
    mesh.CreateFaceVertexCountsAttr([4] * 6)
    mesh.CreateFaceVertexIndicesAttr([0, 1, 3, 2, 4, 6, 7, 5, 0, 4, 5, 1, 2, 3, 7, 6, 0, 2, 6, 4, 1, 5, 7, 3])
    mesh.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
    mesh.CreateDisplayColorAttr([Gf.Vec3f(*color)])
    return mesh


def define_capsule(stage: Usd.Stage, path: str, capsule: Capsule) -> UsdGeom.Capsule:
    """A capsule shape; USD's height, like ours, leaves the caps out."""
    shape = UsdGeom.Capsule.Define(stage, path)
    shape.CreateAxisAttr(capsule.axis)
    shape.CreateRadiusAttr(capsule.radius)
    shape.CreateHeightAttr(capsule.length)
    half = np.full(3, capsule.radius)
    half["XYZ".index(capsule.axis)] += capsule.length / 2
    shape.CreateExtentAttr([Gf.Vec3f(*(-half).tolist()), Gf.Vec3f(*half.tolist())])
    set_pose(shape.GetPrim(), (np.array(capsule.xyz), np.eye(3)))
    return shape


def make_collider(shape: UsdGeom.Gprim, contact: Contact, material: UsdShade.Material) -> None:
    """Turn a shape into an invisible collider (purpose `guide`) of the given surface."""
    prim = shape.GetPrim()
    shape.CreatePurposeAttr(UsdGeom.Tokens.guide)
    UsdPhysics.CollisionAPI.Apply(prim)
    prim.AddAppliedSchema("MjcCollisionAPI")
    attribute(prim, "mjc:condim", "int", contact.condim)
    attribute(prim, "mjc:solref", "double[]", list(contact.solref))
    attribute(prim, "mjc:solimp", "double[]", list(contact.solimp))
    binding = UsdShade.MaterialBindingAPI.Apply(prim)
    binding.Bind(material, materialPurpose="physics")


def _clean(values: np.ndarray) -> list[float]:
    """Plain floats, with what is zero but for rounding set to zero."""
    return np.where(np.abs(values) < 1e-12, 0.0, values).tolist()
