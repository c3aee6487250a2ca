"""One pass over the stage: usd-core's physics descriptors, indexed, plus exact reading of raw attributes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdPhysics

from lift_lab.usd.report import ImportReport, UsdImportError
from lift_lab.usd.stage import is_below
from lift_lab.usd.units import Pose, Units, gf_matrix, polar

if TYPE_CHECKING:
    from lift_lab.usd.inherited import Inherited

_LARGE = 1e12
"""Largest scale and position that is taken seriously."""
TYPES = UsdPhysics.ObjectType
JOINT_TYPES = {
    TYPES.FixedJoint: "fixed",
    TYPES.RevoluteJoint: "revolute",
    TYPES.PrismaticJoint: "prismatic",
    TYPES.SphericalJoint: "spherical",
    TYPES.DistanceJoint: "distance",
    TYPES.D6Joint: "d6",
    TYPES.CustomJoint: "custom",
}
SHAPE_TYPES = {
    TYPES.SphereShape,
    TYPES.CubeShape,
    TYPES.CapsuleShape,
    TYPES.Capsule1Shape,
    TYPES.CylinderShape,
    TYPES.Cylinder1Shape,
    TYPES.ConeShape,
    TYPES.MeshShape,
    TYPES.PlaneShape,
    TYPES.CustomShape,
    TYPES.SpherePointsShape,
}


@dataclass
class Joint:
    """A joint prim with both frames in metres, in its bodies (`body0`, `body1`; None is the world)."""

    path: str
    kind: str
    desc: Any
    body0: str | None
    body1: str | None
    frame0: Pose
    frame1: Pose
    prim: Usd.Prim

    @property
    def excluded(self) -> bool:
        """Whether the joint must stay out of the kinematic tree."""
        return self.desc.excludeFromArticulation or self.kind == "distance"


@dataclass
class ParsedStage:
    """A stage with everything the builders need to look up."""

    stage: Usd.Stage
    source: str
    units: Units
    report: ImportReport
    prims: list[Usd.Prim]
    order: dict[str, int]
    """Traversal index of every prim path: the stage's authored order."""
    bodies: dict[str, Any] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    shapes: dict[str, Any] = field(default_factory=dict)
    articulations: dict[str, Any] = field(default_factory=dict)
    groups: dict[str, Any] = field(default_factory=dict)
    scenes: dict[str, Any] = field(default_factory=dict)
    inherited: dict[str, Inherited] = field(default_factory=dict)
    """Colliders that are ones because of a prim above them, by path."""
    xforms: UsdGeom.XformCache = field(default_factory=UsdGeom.XformCache)

    def prim(self, path: object) -> Usd.Prim:
        return self.stage.GetPrimAtPath(str(path))

    def fail(self, prim: object, attribute: str, reason: str) -> UsdImportError:
        """Build the error for one prim and attribute of this stage."""
        path = prim.GetPath() if isinstance(prim, Usd.Prim) else prim
        return UsdImportError(self.source, str(path), attribute, reason)

    def affine(self, prim: Usd.Prim) -> tuple[np.ndarray, np.ndarray]:
        """World transform of `prim` in the Z-up world: linear part (no unit) and origin in metres."""
        linear, origin = gf_matrix(self.xforms.GetLocalToWorldTransform(prim))
        if not (np.abs(linear).max() < _LARGE and np.abs(origin).max() < _LARGE):
            raise self.fail(prim, "xformOpOrder", f"the world transform is not finite and below {_LARGE:g}")
        return self.units.up @ linear, self.units.up @ origin * self.units.length

    def pose(self, prim: Usd.Prim) -> Pose:
        """World frame of `prim` with its scale taken out."""
        linear, origin = self.affine(prim)
        if abs(np.linalg.det(linear)) < 1e-30:
            raise self.fail(prim, "xformOp:scale", "the world transform is singular")
        return Pose(origin, polar(linear)[0])

    def body_of(self, prim: Usd.Prim) -> str | None:
        """Path of the rigid body that `prim` belongs to: itself or the nearest ancestor it moves with."""
        while prim and not prim.IsPseudoRoot():
            path = str(prim.GetPath())
            if path in self.bodies:
                return path
            if prim.IsA(UsdGeom.Xformable) and UsdGeom.Xformable(prim).GetResetXformStack():
                return None
            prim = prim.GetParent()
        return None


def value_of(prim: Usd.Prim, name: str) -> Any:
    """Authored value of an attribute, or None: fallbacks and blocked values count as not authored."""
    attribute = prim.GetAttribute(name)
    return attribute.Get() if attribute and attribute.HasAuthoredValue() else None


def targets_of(prim: Usd.Prim, name: str) -> list[str]:
    """Forwarded targets of a relationship as strings."""
    relationship = prim.GetRelationship(name)
    return [str(path) for path in relationship.GetForwardedTargets()] if relationship else []


def applied_schemas(prim: Usd.Prim) -> list[str]:
    """API schemas on the prim, unregistered vendor schemas included (HasAPI does not see those)."""
    return list(prim.GetPrimTypeInfo().GetAppliedAPISchemas())


def has_schema(prim: Usd.Prim, name: str) -> bool:
    """Whether an API schema (any instance of a multiple-apply one) is on the prim."""
    return any(s == name or s.startswith(f"{name}:") for s in applied_schemas(prim))


def parse(stage: Usd.Stage, source: str, report: ImportReport, parts: list[Sdf.Path]) -> ParsedStage:
    """Run usd-core's physics parser over the stage and index its descriptors.

    Args:
        stage: The stage.
        source: What to call it in messages.
        report: Takes notes.
        parts: Prims that are passed over, with all below (:func:`lift_lab.usd.stage.prototypes`).

    Raises:
        UsdImportError: A joint names a prim that does not exist, or the same body twice.
    """
    predicate = Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)
    prims = list(Usd.PrimRange(stage.GetPseudoRoot(), predicate))[1:]
    prims = [prim for prim in prims if not is_below(prim.GetPath(), parts)] if parts else prims
    order = {str(prim.GetPath()): i for i, prim in enumerate(prims)}
    parsed = ParsedStage(stage, source, Units.of(stage), report, prims, order)
    for name, value in (("metersPerUnit", parsed.units.length), ("kilogramsPerUnit", parsed.units.mass)):
        if not 1 / _LARGE < value < _LARGE:
            raise UsdImportError(source, attribute=name, reason=f"{value:g} is out of bounds")
    load = getattr(UsdPhysics, "UsdPhysicsLoadStageFromPrimRange", None) or UsdPhysics.LoadUsdPhysicsFromRange
    found = load(stage, ["/"])
    stores = {
        TYPES.RigidBody: parsed.bodies,
        TYPES.Articulation: parsed.articulations,
        TYPES.CollisionGroup: parsed.groups,
        TYPES.Scene: parsed.scenes,
    }
    if parts:
        for kind, (paths, descs) in found.items():
            kept = [(p, d) for p, d in zip(paths, descs, strict=True) if not is_below(p, parts)]
            found[kind] = ([p for p, _ in kept], [d for _, d in kept])
    for kind, (paths, descs) in found.items():
        store = parsed.shapes if kind in SHAPE_TYPES else stores.get(kind)
        if store is not None:
            store.update({str(path): desc for path, desc in zip(paths, descs, strict=True)})
    for store in (parsed.bodies, parsed.shapes):
        for path in sorted(store, key=lambda p: order.get(p, len(order))):
            store[path] = store.pop(path)
    _absorb_disabled_bodies(parsed)
    joints = [
        (str(path), JOINT_TYPES[kind], desc)
        for kind, (paths, descs) in found.items()
        if kind in JOINT_TYPES
        for path, desc in zip(paths, descs, strict=True)
    ]
    for path, kind, desc in sorted(joints, key=lambda item: order.get(item[0], len(order))):
        joint = _joint(parsed, path, kind, desc)
        if joint:
            parsed.joints[path] = joint
    return parsed


def _absorb_disabled_bodies(parsed: ParsedStage) -> None:
    """Let a disabled body below an enabled one be part of that, as usd-core's parser has it; others are static."""
    every = parsed.bodies
    parsed.bodies = {path: body for path, body in every.items() if body.rigidBodyEnabled}
    parsed.bodies = {
        path: body for path, body in every.items() if body.rigidBodyEnabled or parsed.body_of(parsed.prim(path)) is None
    }


def _joint(parsed: ParsedStage, path: str, kind: str, desc: Any) -> Joint | None:
    prim = parsed.prim(path)
    for attribute in ("physics:body0", "physics:body1"):
        for target in targets_of(prim, attribute):
            if not parsed.prim(target):
                raise parsed.fail(prim, attribute, f"no prim at <{target}>")
    if not desc.jointEnabled:
        parsed.report.ignore(path, "physics:jointEnabled", "the joint is disabled")
        return None
    body0, body1 = (str(p) if p and str(p) in parsed.bodies else None for p in (desc.body0, desc.body1))
    if body0 == body1:
        if body0 is None:
            if has_schema(prim, "PhysicsArticulationRootAPI"):
                reason = "the joint that should fix an articulation to the world holds no rigid body"
                raise parsed.fail(prim, "physics:body1", reason)
            parsed.report.ignore(path, "", "neither side of the joint is a rigid body")
            return None
        raise parsed.fail(prim, "physics:body1", f"both sides of the joint are the body <{body0}>")
    frame0 = _frame(parsed, body0, desc.body0, desc.localPose0Position, desc.localPose0Orientation)
    frame1 = _frame(parsed, body1, desc.body1, desc.localPose1Position, desc.localPose1Orientation)
    frame0 = _unsheared(parsed, body0, str(desc.rel0), value_of(prim, "physics:localPos0"), frame0)
    frame1 = _unsheared(parsed, body1, str(desc.rel1), value_of(prim, "physics:localPos1"), frame1)
    if not all(np.isfinite(f.pos).all() and np.isfinite(f.rot).all() for f in (frame0, frame1)):
        raise parsed.fail(prim, "physics:localPos0", "a joint frame is not finite")
    return Joint(path, kind, desc, body0, body1, frame0, frame1, prim)


def _frame(parsed: ParsedStage, body: str | None, owner: object, position: object, orientation: object) -> Pose:
    """Joint frame in its body, or in the Z-up world for a side without one."""
    frame = Pose.of(position, orientation, parsed.units.length)
    if body:
        return frame
    if owner:  # the parser gives it relative to a static collider
        return parsed.pose(parsed.prim(owner)) @ frame
    return Pose(np.zeros(3), parsed.units.up) @ frame


def _unsheared(parsed: ParsedStage, body: str | None, owner: str, position: object, frame: Pose) -> Pose:
    """The joint frame with its position as the prim's whole transform has it, shear included.

    usd-core multiplies a position by three scales, which are not all of a transform whose scale is at an angle to the
    prim's axes. `owner` is the prim that the joint names, `position` what is authored.
    """
    prim = parsed.prim(owner) if owner else None
    if not prim or not prim.IsA(UsdGeom.Xformable):
        return frame
    linear, origin = parsed.affine(prim)
    stretch = polar(linear)[1]
    if np.abs(stretch - np.diag(np.diag(stretch))).max() <= 1e-6 * np.abs(stretch).max():
        return frame
    local = np.zeros(3) if position is None else np.asarray(position, dtype=float)
    point = origin + linear @ local * parsed.units.length
    if body:
        home = parsed.pose(parsed.prim(body))
        point = home.rot.T @ (point - home.pos)
    return Pose(point, frame.rot)
