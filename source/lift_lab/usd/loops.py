"""Equality constraints: joints that close a loop or stay out of the articulation, and joints that mimic another."""

from __future__ import annotations

import mujoco
import numpy as np
from pxr import Usd

from lift_lab.usd.joints import BuiltDof, Dof, add_joints, dofs_of
from lift_lab.usd.names import Names
from lift_lab.usd.parse import Joint, ParsedStage, applied_schemas, targets_of, value_of
from lift_lab.usd.tree import Edge, Link
from lift_lab.usd.units import UNBOUNDED, Pose

_SPAN = 0.1
"""Distance in m between the two points that hold a hinge on its axis."""
_SITE_GROUP = 5
_CARRIER_SHARE = 1e-3
"""Mass and inertia of a carrier as a share of the lighter of the two bodies that its joint connects."""

_CARRIER_IMPEDANCE = 0.9999
"""Largest impedance that MuJoCo has."""


def add_loops(
    parsed: ParsedStage,
    spec: mujoco.MjSpec,
    names: Names,
    loops: list[Joint],
    body_names: dict[str, str],
) -> list[BuiltDof]:
    """Turn left-over joints into equalities between sites, which hold for every reference pose.

    fixed: weld; spherical: connect; revolute: two connects along the axis; distance: a tendon with a range. A joint
    that slides, has several degrees of freedom, limits or a drive moves a light carrier on its first body. A weld holds
    the carrier to the second body.

    Returns:
        The scalar joints of the carriers.
    """
    built: list[BuiltDof] = []
    for joint in loops:
        builder = _Loop(parsed, spec, names, joint, body_names)
        dofs = dofs_of(parsed, joint)
        free = {token for dof in dofs for token in dof.tokens[-1:]}
        plain = not any(_limited(dof) for dof in dofs) and not _has_cone(joint)
        if joint.kind == "custom":
            continue  # the audit says so
        if joint.kind == "distance":
            builder.distance()
        elif joint.kind == "fixed" or not dofs:
            builder.weld(builder.bodies)
        elif plain and free == {"rotX", "rotY", "rotZ"}:
            builder.connect("", np.zeros(3))
        elif plain and len(free) == 1 and dofs[0].angular:
            builder.connect("", np.zeros(3))
            builder.connect("_axis", _SPAN * dofs[0].axis)
        else:
            built += builder.carrier()
            continue
        if joint.desc.breakForce < UNBOUNDED or joint.desc.breakTorque < UNBOUNDED:
            parsed.report.ignore(joint.path, "physics:breakForce", "joints do not break")
    return built


def _limited(dof: Dof) -> bool:
    return dof.drive is not None or abs(dof.lower) < UNBOUNDED or abs(dof.upper) < UNBOUNDED


def _has_cone(joint: Joint) -> bool:
    limit = getattr(joint.desc, "limit", None) if joint.kind == "spherical" else None
    return limit is not None and limit.enabled


class _Loop:
    def __init__(
        self, parsed: ParsedStage, spec: mujoco.MjSpec, names: Names, joint: Joint, body_names: dict[str, str]
    ) -> None:
        self.parsed, self.spec, self.names, self.joint = parsed, spec, names, joint
        self.bodies = [spec.body(body_names[b]) if b else spec.worldbody for b in (joint.body0, joint.body1)]

    def sites(
        self, suffix: str, offset: np.ndarray, bodies: list[mujoco.MjsBody], first: Pose | None = None
    ) -> tuple[str, str]:
        """Sites on two bodies that the joint holds together, displaced by `offset` in the joint frame.

        `first` is the joint frame in the first body, where that is not the joint's own.
        """
        made = []
        frames = (self.joint.frame0 if first is None else first, self.joint.frame1)
        for side, (body, frame) in enumerate(zip(bodies, frames, strict=True)):
            pose = frame @ Pose(offset, np.eye(3))
            name = self.names.of("site", self.joint.path, f"{suffix}_{side}")
            body.add_site(name=name, pos=pose.position, quat=pose.quat, size=[0.005] * 3, group=_SITE_GROUP)
            made.append(name)
        return made[0], made[1]

    def _equality(self, kind: mujoco.mjtEq, suffix: str, sites: tuple[str, str]) -> mujoco.MjsEquality:
        equality = self.spec.add_equality(
            name=self.names.of("equality", self.joint.path, suffix),
            type=kind,
            name1=sites[0],
            name2=sites[1],
            objtype=mujoco.mjtObj.mjOBJ_SITE,
        )
        set_solver(self.joint.prim, equality)
        return equality

    def weld(self, bodies: list[mujoco.MjsBody], first: Pose | None = None) -> mujoco.MjsEquality:
        equality = self._equality(mujoco.mjtEq.mjEQ_WELD, "", self.sites("", np.zeros(3), bodies, first))
        scale = value_of(self.joint.prim, "mjc:torqueScale")
        data = np.zeros(len(equality.data))
        data[10] = 1.0 if scale is None else float(scale)
        equality.data = data
        return equality

    def connect(self, suffix: str, offset: np.ndarray) -> None:
        equality = self._equality(mujoco.mjtEq.mjEQ_CONNECT, suffix, self.sites(suffix, offset, self.bodies))
        equality.data = np.zeros(len(equality.data))

    def carrier(self) -> list[BuiltDof]:
        """A light body that moves on the first body as the joint allows, welded to the second."""
        joint, frame = self.joint, self.joint.frame0
        masses = [float(body.mass) for body in self.bodies if body.mass > 0]
        sizes = [float(np.mean(body.inertia)) for body in self.bodies if body.mass > 0]
        body = self.bodies[0].add_body(
            name=self.names.of("body", joint.path, "_carrier"), pos=frame.position, quat=frame.quat
        )
        body.mass = _CARRIER_SHARE * min(masses, default=1.0)
        body.inertia = [_CARRIER_SHARE * min(sizes, default=0.01)] * 3
        body.explicitinertial = True
        self.parsed.report.prim_paths[body.name] = joint.path
        edge = Edge(joint, frame, Pose.identity(), reversed=False)
        built = add_joints(self.parsed, self.names, Link(joint.path, joint.body0, [edge]), body)
        for dof in built:
            dof.edge = Edge(joint, frame, joint.frame1, reversed=False)
            if dof.dof.drive is not None:
                # A drive on the light carrier would be lost in the weld; between the bodies it is exact.
                dof.sites = dof.sites or self.sites(f"_{dof.name}_drive", np.zeros(3), self.bodies)
        weld = self.weld([body, self.bodies[1]], Pose.identity())
        if value_of(joint.prim, "mjc:solimp") is None:
            # MuJoCo softens a constraint by the mean mobility of its bodies, which the light carrier makes large.
            weld.solimp = [_CARRIER_IMPEDANCE, _CARRIER_IMPEDANCE, *list(weld.solimp)[2:]]
        reason = f"closes a loop: moves a carrier of {body.mass:.2g} kg that is welded to its second body"
        self.parsed.report.approximate(joint.path, "physics:body1", reason)
        return built

    def distance(self) -> None:
        desc, unit = self.joint.desc, self.parsed.units.length
        lower = desc.limit.lower * unit if desc.minEnabled else 0.0
        upper = desc.limit.upper * unit if desc.maxEnabled else 1e6
        if upper <= lower:
            upper = lower + 1e-6
        first, second = self.sites("", np.zeros(3), self.bodies)
        tendon = self.spec.add_tendon(name=self.names.of("tendon", self.joint.path))
        tendon.wrap_site(first)
        tendon.wrap_site(second)
        tendon.range, tendon.limited = [lower, upper], mujoco.mjtLimited.mjLIMITED_TRUE


def set_solver(prim: Usd.Prim, equality: mujoco.MjsEquality) -> None:
    """Write `mjc:solref` and `mjc:solimp` of a prim to its equality."""
    for name in ("solref", "solimp"):
        value = value_of(prim, f"mjc:{name}")
        if value is not None:
            merged = np.array(getattr(equality, name), dtype=float)
            merged[: len(value)] = np.array(value, dtype=float)[: len(merged)]
            setattr(equality, name, merged)


def add_mimics(parsed: ParsedStage, spec: mujoco.MjSpec, names: Names, dofs: list[BuiltDof]) -> None:
    """Joint equalities `follower = c0 + c1 * leader` from all three dialects, one per follower."""
    by_joint: dict[str, list[BuiltDof]] = {}
    for built in dofs:
        by_joint.setdefault(built.joint.path, []).append(built)
    for path, followers in by_joint.items():
        prim = parsed.prim(path)
        schemas = applied_schemas(prim)
        if "MjcEqualityJointAPI" in schemas or "NewtonMimicAPI" in schemas:
            _newton_mimic(parsed, spec, names, prim, followers, by_joint, "MjcEqualityJointAPI" in schemas)
            continue
        for schema in schemas:
            if schema.startswith("PhysxMimicJointAPI:"):
                _physx_mimic(parsed, spec, names, prim, schema.split(":", 1)[1], followers, by_joint)


def _leader(
    parsed: ParsedStage, prim: Usd.Prim, relationship: str, axis: str | None, by_joint: dict[str, list[BuiltDof]]
) -> BuiltDof | None:
    targets = targets_of(prim, relationship)
    if not targets:
        raise parsed.fail(prim, relationship, "a mimic joint names no joint to follow")
    if not parsed.prim(targets[0]):
        raise parsed.fail(prim, relationship, f"no prim at <{targets[0]}>")
    choices = by_joint.get(targets[0], [])
    if not choices:
        parsed.report.ignore(prim.GetPath(), relationship, f"<{targets[0]}> has no scalar joint in the tree")
        return None
    return next((built for built in choices if axis in built.dof.tokens), choices[0])


def _newton_mimic(
    parsed: ParsedStage,
    spec: mujoco.MjSpec,
    names: Names,
    prim: Usd.Prim,
    followers: list[BuiltDof],
    by_joint: dict[str, list[BuiltDof]],
    mjc: bool,
) -> None:
    if value_of(prim, "newton:mimicEnabled") is False:
        return
    relationship = "newton:mimicJoint" if targets_of(prim, "newton:mimicJoint") or not mjc else "mjc:target"
    leader = _leader(parsed, prim, relationship, None, by_joint)
    if leader is None:
        return
    follower = followers[0]
    data = [0.0, 1.0, 0.0, 0.0, 0.0]
    # newton's offset is in the follower's degrees, mjc's coefficients are MJCF's.
    for i in range(5):
        value = value_of(prim, f"mjc:coef{i}")
        if value is not None:
            data[i] = float(value)
    for i, unit in ((0, parsed.units.factor("position", follower.dof.angular)), (1, 1.0)):
        value = value_of(prim, f"newton:mimicCoef{i}")
        if value is not None:
            data[i] = float(value) * unit
    parsed.report.took("mimic", "mjc" if relationship == "mjc:target" else "newton")
    set_solver(prim, _couple(spec, names, follower, leader, data))


def _physx_mimic(
    parsed: ParsedStage,
    spec: mujoco.MjSpec,
    names: Names,
    prim: Usd.Prim,
    axis: str,
    followers: list[BuiltDof],
    by_joint: dict[str, list[BuiltDof]],
) -> None:
    key = f"physxMimicJoint:{axis}"
    reference_axis = value_of(prim, f"{key}:referenceJointAxis")
    leader = _leader(parsed, prim, f"{key}:referenceJoint", reference_axis, by_joint)
    if leader is None:
        return
    # One instance name serves for the only axis of a single-axis joint, whichever that is (rotX on a slide too).
    follower = next((built for built in followers if axis in built.dof.tokens), followers[0])
    gearing, offset = value_of(prim, f"{key}:gearing"), value_of(prim, f"{key}:offset")
    gearing, offset = 1.0 if gearing is None else float(gearing), 0.0 if offset is None else float(offset)
    units = [parsed.units.factor("position", built.dof.angular) for built in (follower, leader)]
    parsed.report.took("mimic", "physx")
    _couple(spec, names, follower, leader, [-offset * units[0], -gearing * units[0] / units[1], 0.0, 0.0, 0.0])


def _couple(
    spec: mujoco.MjSpec, names: Names, follower: BuiltDof, leader: BuiltDof, data: list[float]
) -> mujoco.MjsEquality:
    equality = spec.add_equality(
        name=names.of("equality", follower.joint.path, "_mimic"),
        type=mujoco.mjtEq.mjEQ_JOINT,
        name1=follower.name,
        name2=leader.name,
        objtype=mujoco.mjtObj.mjOBJ_JOINT,
    )
    padded = np.zeros(len(equality.data))
    padded[: len(data)] = data
    equality.data = padded
    return equality
