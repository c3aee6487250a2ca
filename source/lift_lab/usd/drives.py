"""Joint drives as MuJoCo actuators, and the control and state that a stage starts with."""

from __future__ import annotations

import mujoco
import numpy as np

from lift_lab.usd import dialects
from lift_lab.usd.joints import BuiltDof
from lift_lab.usd.names import Names
from lift_lab.usd.parse import ParsedStage
from lift_lab.usd.report import ImportReport
from lift_lab.usd.tree import Forest
from lift_lab.usd.units import UNBOUNDED, Pose


def add_drives(parsed: ParsedStage, spec: mujoco.MjSpec, names: Names, dofs: list[BuiltDof]) -> set[str]:
    """Add an actuator per drive with gains, named as its joint.

    A drive applies `stiffness * (target - q) + damping * (target velocity - qd)`. With stiffness it becomes a position
    actuator. A second actuator `<joint>_velocity` then carries a target velocity other than zero. Without stiffness it
    becomes a velocity actuator. maxForce bounds the joint's total actuator force.

    Returns:
        Names of the actuators whose gains are per unit inertia (`type = "acceleration"`).
    """
    acceleration = set()
    for built in dofs:
        drive, dof, path = built.dof.drive, built.dof, built.joint.path
        if drive is None:
            continue
        numbers = (drive.stiffness, drive.damping, drive.forceLimit, drive.targetPosition, drive.targetVelocity)
        if np.isnan(numbers).any():
            raise parsed.fail(path, f"drive:{dof.tokens[0]}", "a drive value is not a number")
        if drive.stiffness < 0 or drive.damping < 0:
            raise parsed.fail(path, f"drive:{dof.tokens[0]}", "stiffness and damping must not be negative")
        if built.sites and drive.acceleration:
            reason = "a drive per unit of inertia on a joint that closes a loop"
            parsed.report.ignore(path, f"drive:{dof.tokens[0]}:physics:type", reason)
            continue
        if drive.forceLimit == 0:  # it may not push at all
            continue
        _limit_force(parsed, built)
        # Acceleration drives state gains per unit of inertia: s^-2 and s^-1, per degree if angular.
        unit = parsed.units.factor("gain", dof.angular)
        if drive.acceleration:
            unit = unit / parsed.units.factor("gain_rad", dof.angular)
        stiffness, damping = drive.stiffness * unit, drive.damping * unit
        if stiffness == 0 and damping == 0:
            continue
        target = drive.targetPosition * parsed.units.factor("position", dof.angular)
        velocity = drive.targetVelocity * parsed.units.factor("velocity", dof.angular)
        made: list[tuple[str, float]] = []
        if stiffness > 0:
            made.append((_actuator(spec, names, built, "", stiffness, (0.0, -stiffness, -damping)), target))
            if velocity != 0 and damping > 0:
                made.append((_actuator(spec, names, built, "_velocity", damping, (0.0, 0.0, 0.0)), velocity))
        else:
            made.append((_actuator(spec, names, built, "", damping, (0.0, 0.0, -damping)), velocity))
        for name, ctrl in made:
            if built.sites:
                parsed.report.loop_drives[name] = built.name
            if ctrl != 0:
                parsed.report.initial_ctrl[name] = ctrl
            if drive.acceleration:
                acceleration.add(name)
    return acceleration


def _actuator(
    spec: mujoco.MjSpec,
    names: Names,
    built: BuiltDof,
    suffix: str,
    gain: float,
    bias: tuple[float, float, float],
) -> str:
    name = names.of("actuator", f"/{built.name}{suffix}")
    actuator = spec.add_actuator(name=name, target=built.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    if built.sites:
        actuator.trntype = mujoco.mjtTrn.mjTRN_SITE
        actuator.refsite, actuator.target = built.sites
        actuator.gear = [*(np.zeros(3) if built.dof.angular else built.dof.axis), *built.dof.axis * built.dof.angular]
        actuator.forcerange, actuator.forcelimited = built.element.actfrcrange, built.element.actfrclimited
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    actuator.gainprm = [gain] + [0.0] * (len(actuator.gainprm) - 1)
    actuator.biasprm = [*bias] + [0.0] * (len(actuator.biasprm) - len(bias))
    return name


def _limit_force(parsed: ParsedStage, built: BuiltDof) -> None:
    limit, path = built.dof.drive.forceLimit, built.joint.path
    if limit >= UNBOUNDED or built.element.actfrclimited == mujoco.mjtLimited.mjLIMITED_TRUE:
        return
    if limit < 0:
        raise parsed.fail(path, f"drive:{built.dof.tokens[0]}:physics:maxForce", f"must not be negative, is {limit:g}")
    force = limit * parsed.units.factor("effort", built.dof.angular)
    built.element.actfrcrange = [-force, force]
    built.element.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE


def scale_acceleration_drives(parsed: ParsedStage, spec: mujoco.MjSpec, names: set[str]) -> None:
    """Turn gains per unit inertia into gains: times the joint's inertia in the reference pose (`dof_M0`)."""
    if not names:
        return
    model = spec.compile()
    for name in sorted(names):
        actuator = spec.actuator(name)
        inertia = float(model.dof_M0[model.jnt_dofadr[model.joint(actuator.target).id]])
        actuator.gainprm = np.asarray(actuator.gainprm) * inertia
        actuator.biasprm = np.asarray(actuator.biasprm) * inertia
        reason = f"gains per unit inertia, scaled by the inertia {inertia:.4g} of the reference pose"
        parsed.report.approximate(actuator.target, "drive:type", reason)


def read_start(parsed: ParsedStage, forest: Forest, dofs: list[BuiltDof]) -> None:
    """Initial joint positions: an authored joint state, else the angle or travel that the authored poses imply."""
    siblings: dict[str, int] = {}
    for built in dofs:
        siblings[built.joint.path] = siblings.get(built.joint.path, 0) + 1
    edges = {edge.joint.path: len(link.edges) for link in forest.links.values() for edge in link.edges}
    for built in dofs:
        dof, joint = built.dof, built.joint
        value = dialects.resolve(parsed, dialects.JOINT, "joint position", joint.prim, dof.tokens, dof.angular)
        if value is None and edges.get(joint.path, 1) == siblings[joint.path] == 1:
            value = _implied(parsed, built)
        if value:
            parsed.report.initial_joint_pos[built.name] = float(value) + float(built.element.ref)


def _implied(parsed: ParsedStage, built: BuiltDof) -> float | None:
    edge = built.edge
    sides = (edge.joint.body1, edge.joint.body0) if edge.reversed else (edge.joint.body0, edge.joint.body1)
    parent, child = (parsed.pose(parsed.prim(path)) if path else Pose.identity() for path in sides)
    moved = (parent @ edge.parent_frame).inverse() @ child @ edge.child_frame
    axis = -built.dof.axis if edge.reversed else built.dof.axis
    if built.dof.angular:
        turn = np.array(
            [moved.rot[2, 1] - moved.rot[1, 2], moved.rot[0, 2] - moved.rot[2, 0], moved.rot[1, 0] - moved.rot[0, 1]]
        )
        value = float(np.arctan2(turn @ axis, np.trace(moved.rot) - 1.0))
    else:
        value = float(moved.pos @ axis)
    return value if abs(value) > 1e-5 else None


def add_initial_key(spec: mujoco.MjSpec, report: ImportReport, name: str = "initial") -> None:
    """Store the report's initial joint positions and controls in a keyframe.

    It is not part of `load`, because a keyframe fits only the spec it was made for and specs are meant to be attached.
    """
    model = spec.compile()
    qpos, ctrl = model.qpos0.copy(), np.zeros(model.nu)
    for joint, value in report.initial_joint_pos.items():
        qpos[model.jnt_qposadr[model.joint(joint).id]] = value
    for actuator, value in report.initial_ctrl.items():
        ctrl[model.actuator(actuator).id] = value
    spec.add_key(name=name, qpos=qpos, ctrl=ctrl)
