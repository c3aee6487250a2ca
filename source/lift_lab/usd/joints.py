"""Tree joints: degrees of freedom of each USD joint, and the MuJoCo joints made from them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from pxr import UsdPhysics

from lift_lab.usd import dialects
from lift_lab.usd.names import Names
from lift_lab.usd.parse import Joint, ParsedStage, value_of
from lift_lab.usd.tree import Edge, Link
from lift_lab.usd.units import AXES, UNBOUNDED, Pose

_D6 = {
    UsdPhysics.JointDOF.TransX: "transX",
    UsdPhysics.JointDOF.TransY: "transY",
    UsdPhysics.JointDOF.TransZ: "transZ",
    UsdPhysics.JointDOF.RotX: "rotX",
    UsdPhysics.JointDOF.RotY: "rotY",
    UsdPhysics.JointDOF.RotZ: "rotZ",
    UsdPhysics.JointDOF.Distance: "distance",
}
_WIDE = 1e6
"""Bound that stands for infinity where only one side of a limit is finite (MuJoCo wants both)."""
_LOCK = 1e-6
"""Half-width, in rad or m, of a limit whose two sides coincide."""


@dataclass
class Dof:
    """One scalar degree of freedom: `axis` in the joint frame, limits in the stage's units (deg or length)."""

    tokens: tuple[str, ...]
    angular: bool
    axis: np.ndarray
    lower: float
    upper: float
    drive: Any = None


@dataclass
class BuiltDof:
    """A scalar MuJoCo joint and where it came from."""

    joint: Joint
    dof: Dof
    name: str
    element: mujoco.MjsJoint
    axis: np.ndarray
    """Axis in the child body."""
    edge: Edge
    sites: tuple[str, str] | None = None
    """For a joint that closes a loop: sites on its two bodies, between which a drive acts."""


def dofs_of(parsed: ParsedStage, joint: Joint) -> list[Dof]:
    """Scalar degrees of freedom of a joint, slides before hinges; empty if it locks all, spherical ones as three."""
    desc = joint.desc
    unit = np.eye(3)
    if joint.kind in ("revolute", "prismatic"):
        angular = joint.kind == "revolute"
        axis = str(desc.axis).rsplit(".", 1)[-1][-1]
        tokens = ("angular", f"rot{axis}") if angular else ("linear", f"trans{axis}")
        drive = desc.drive if desc.drive.enabled else None
        # `limit.enabled` asks for both sides to be finite; the values are good either way.
        return [Dof(tokens, angular, unit[AXES[axis]], desc.limit.lower, desc.limit.upper, drive)]
    if joint.kind == "spherical":
        return [Dof((f"rot{a}",), True, unit[i], -math.inf, math.inf) for a, i in AXES.items()]
    if joint.kind != "d6":
        return []
    limits = {_D6[pair.first]: pair.second for pair in desc.jointLimits if pair.first in _D6}
    drives = {_D6[pair.first]: pair.second for pair in desc.jointDrives if pair.first in _D6}
    if "distance" in limits:
        parsed.report.ignore(joint.path, "limit:distance", "a D6 joint has no distance limit here")
    found = []
    for kind in ("trans", "rot"):
        for a, i in AXES.items():
            token = f"{kind}{a}"
            limit, drive = limits.get(token), drives.get(token)
            lower, upper = (limit.lower, limit.upper) if limit else _unapplied_limit(parsed, joint, token)
            if lower > upper or lower == upper == 0:
                continue
            drive = drive if drive and drive.enabled else None
            found.append(Dof((token,), kind == "rot", unit[i], lower, upper, drive))
    return found


def _unapplied_limit(parsed: ParsedStage, joint: Joint, token: str) -> tuple[float, float]:
    """Limits of a D6 axis without LimitAPI: those authored all the same, as other importers read them; else none."""
    ends = [value_of(joint.prim, f"limit:{token}:physics:{end}") for end in ("low", "high")]
    if ends == [None, None]:
        return -math.inf, math.inf
    parsed.report.approximate(joint.path, f"limit:{token}:physics:low", "taken although its LimitAPI is not applied")
    return (-math.inf if ends[0] is None else float(ends[0])), (math.inf if ends[1] is None else float(ends[1]))


def add_joints(parsed: ParsedStage, names: Names, link: Link, body: mujoco.MjsBody) -> list[BuiltDof]:
    """Add the joints of one link to its body.

    Returns:
        The scalar joints, in model order; ball joints are added but not listed.
    """
    built: list[BuiltDof] = []
    first = link.edges[0].offset if link.edges else Pose.identity()
    # A chain of joints from body0 to body1 reads the other way round from body1.
    backwards = bool(link.edges) and all(edge.reversed for edge in link.edges)
    for edge in reversed(link.edges) if backwards else link.edges:
        gap = first.inverse() @ edge.offset
        if edge is not link.edges[0] and (np.abs(gap.pos).max() > 1e-4 or np.abs(gap.rot - np.eye(3)).max() > 1e-3):
            reason = "its frames disagree with those of the first joint between the same bodies at position zero"
            parsed.report.approximate(edge.joint.path, "physics:localPos0", reason)
        built += _add_edge(parsed, names, edge, body)
    free = sum({mujoco.mjtJoint.mjJNT_BALL: 3}.get(joint.type, 1) for joint in body.joints)
    if len(link.edges) > 1 and free > 6:
        path = link.edges[-1].joint.path
        raise parsed.fail(path, "physics:body1", f"joints between the same two bodies leave {free} degrees of freedom")
    return built


def _add_edge(parsed: ParsedStage, names: Names, edge: Edge, body: mujoco.MjsBody) -> list[BuiltDof]:
    joint, path = edge.joint, edge.joint.path
    dofs = dofs_of(parsed, joint)
    rotations = [dof for dof in dofs if dof.angular]
    ball = len(rotations) == 3 and all(_unbounded(dof) and dof.drive is None for dof in rotations)
    scalars = [dof for dof in dofs if not (ball and dof.angular)]
    kept = []
    for dof in scalars:
        if dof.lower > dof.upper:
            parsed.report.approximate(path, "physics:lowerLimit", "lower limit above the upper one: locked at zero")
        else:
            kept.append(dof)
    if len(rotations) > 1 and not ball:
        parsed.report.approximate(path, "", f"{len(rotations)} rotations become hinges in the order X, Y, Z")
    if ball and edge.reversed:
        _add_ball(parsed, names.of("joint", path, "_rot" if kept else ""), edge, body)
    built = []
    for dof in reversed(kept) if edge.reversed else kept:
        suffix = f"_{dof.tokens[0]}" if len(kept) + ball > 1 else ""
        built.append(_add_scalar(parsed, names.of("joint", path, suffix), edge, dof, body))
    if ball and not edge.reversed:
        _add_ball(parsed, names.of("joint", path, "_rot" if kept else ""), edge, body)
    if joint.desc.breakForce < UNBOUNDED or joint.desc.breakTorque < UNBOUNDED:
        parsed.report.ignore(path, "physics:breakForce", "joints do not break")
    return built


def _unbounded(dof: Dof) -> bool:
    return abs(dof.lower) >= UNBOUNDED and abs(dof.upper) >= UNBOUNDED


def _add_ball(parsed: ParsedStage, name: str, edge: Edge, body: mujoco.MjsBody) -> None:
    joint = edge.joint
    element = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_BALL, pos=edge.child_frame.position)
    limit = getattr(joint.desc, "limit", None)
    if limit is not None and limit.enabled:
        cones = [angle for angle in (limit.lower, limit.upper) if 0 <= angle < 180]
        if cones:
            element.range = [0.0, math.radians(min(cones))]
            element.limited = mujoco.mjtLimited.mjLIMITED_TRUE
            reason = "the smaller cone angle limits the total rotation, twist included"
            parsed.report.approximate(joint.path, "physics:coneAngle0Limit", reason)
    _passive(parsed, joint, element, ("rotX", "rotY", "rotZ"), angular=True)


def _add_scalar(parsed: ParsedStage, name: str, edge: Edge, dof: Dof, body: mujoco.MjsBody) -> BuiltDof:
    joint = edge.joint
    sign = -1.0 if edge.reversed else 1.0
    axis = sign * (edge.child_frame.rot @ dof.axis)
    kind = mujoco.mjtJoint.mjJNT_HINGE if dof.angular else mujoco.mjtJoint.mjJNT_SLIDE
    element = body.add_joint(name=name, type=kind, pos=edge.child_frame.position, axis=axis)
    unit = parsed.units.factor("position", dof.angular)
    if _unbounded(dof):
        element.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    else:
        if math.isnan(dof.lower) or math.isnan(dof.upper):
            raise parsed.fail(joint.path, "physics:lowerLimit", "a limit is not a number")
        bounds = [max(dof.lower * unit, -_WIDE), min(dof.upper * unit, _WIDE)]
        if bounds[1] - bounds[0] < 2 * _LOCK:
            middle = 0.5 * sum(bounds)
            bounds = [middle - _LOCK, middle + _LOCK]
            parsed.report.approximate(joint.path, "physics:lowerLimit", "the limits coincide: held by a narrow range")
        element.range = bounds
        element.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    _passive(parsed, joint, element, dof.tokens, dof.angular)
    _mjc_fields(parsed, joint, element, dof.angular)
    _urdf_effort(parsed, dof, joint, element)
    limit = dialects.resolve(parsed, dialects.JOINT, "velocity limit", joint.prim, dof.tokens, dof.angular)
    if limit is not None and limit < UNBOUNDED * unit:
        parsed.report.joint_velocity_limits[name] = limit
    return BuiltDof(joint, dof, name, element, axis, edge)


def _passive(
    parsed: ParsedStage, joint: Joint, element: mujoco.MjsJoint, tokens: tuple[str, ...], angular: bool
) -> None:
    def read(quantity: str) -> Any:
        return dialects.resolve(parsed, dialects.JOINT, quantity, joint.prim, tokens, angular)

    for quantity in ("armature", "frictionloss"):
        value = read(quantity)
        if value is not None:
            if value < 0:
                raise parsed.fail(joint.prim, quantity, f"must not be negative, is {value:g}")
            setattr(element, quantity, value)
    for quantity in ("damping", "stiffness"):
        value = read(quantity)
        if value is not None:
            # MuJoCo 4 keeps a polynomial here; the first coefficient is the linear one.
            coefficients = np.zeros_like(np.atleast_1d(np.asarray(getattr(element, quantity), dtype=float)))
            coefficients[0] = value
            setattr(element, quantity, coefficients if coefficients.size > 1 else float(value))
    margin = read("margin")
    if margin is not None:
        element.margin = margin


def mjc_angle(parsed: ParsedStage) -> float:
    """Radians per unit of the angles that MjcPhysics keeps in MJCF's compiler unit (ref, springref)."""
    for path in parsed.scenes:
        if value_of(parsed.prim(path), "mjc:compiler:angle") == "radian":
            return 1.0
    return math.pi / 180


def _mjc_fields(parsed: ParsedStage, joint: Joint, element: mujoco.MjsJoint, angular: bool) -> None:
    prim = joint.prim
    angle = mjc_angle(parsed) if angular else 1.0
    for name in ("ref", "springref"):
        value = value_of(prim, f"mjc:{name}")
        if value is not None:
            setattr(element, name, float(value) * angle)
    for name, field in (
        ("solreflimit", "solref_limit"),
        ("solimplimit", "solimp_limit"),
        ("solreffriction", "solref_friction"),
        ("solimpfriction", "solimp_friction"),
        ("springdamper", "springdamper"),
    ):
        value = value_of(prim, f"mjc:{name}")
        if value is not None:
            setattr(element, field, _padded(getattr(element, field), value))
    group = value_of(prim, "mjc:group")
    if group is not None:
        element.group = int(group)
    if value_of(prim, "mjc:actuatorgravcomp"):
        element.actgravcomp = True
    lower, upper = (value_of(prim, f"mjc:actuatorfrcrange:{end}") for end in ("min", "max"))
    limited = value_of(prim, "mjc:actuatorfrclimited") or "auto"
    if (lower is not None or upper is not None) and limited != "false":
        lower, upper = float(lower or 0.0), float(upper or 0.0)
        if lower < upper:
            element.actfrcrange = [lower, upper]
            element.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE


def _urdf_effort(parsed: ParsedStage, dof: Dof, joint: Joint, element: mujoco.MjsJoint) -> None:
    """The effort limit that urdf-usd-converter keeps (N m or N), where no schema of physics has a say."""
    effort = value_of(joint.prim, "urdf:limit:effort")
    if effort is None or element.actfrclimited == mujoco.mjtLimited.mjLIMITED_TRUE:
        return
    if dof.drive is not None and dof.drive.forceLimit < UNBOUNDED:
        return
    if not effort >= 0:
        raise parsed.fail(joint.prim, "urdf:limit:effort", f"must not be negative, is {effort:g}")
    if 0 < effort < UNBOUNDED:
        element.actfrcrange = [-effort, effort]
        element.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE


def _padded(current: Any, value: Any) -> list[float]:
    """`value` laid over the leading entries of `current`, which keeps its length."""
    merged = [float(v) for v in current]
    given = [float(v) for v in value][: len(merged)]
    merged[: len(given)] = given
    return merged
