"""NewtonActuator prims: PD control laws with effort bounds, in radians, beside the drives of the joints."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from pxr import Usd

from lift_lab.usd.joints import BuiltDof
from lift_lab.usd.names import Names
from lift_lab.usd.parse import ParsedStage, applied_schemas, targets_of, value_of
from lift_lab.usd.units import UNBOUNDED

KIND = "NewtonActuator"
_LAWS = ("NewtonPDControlAPI", "NewtonPIDControlAPI", "NewtonNeuralControlAPI")


def add_newton_actuators(parsed: ParsedStage, spec: mujoco.MjSpec, names: Names, dofs: list[BuiltDof]) -> None:
    """Add an actuator for every NewtonActuator prim, named as the prim.

    effort = constEffort + kp * (target - q) - kd * qd, clamped to the largest effort that the prim's clamping schemas
    allow at rest. One that may give no effort becomes no actuator. What MuJoCo's PD actuator lacks (an integral, a
    neural law, a delay, bounds that depend on speed or position) is reported.

    Raises:
        UsdImportError: There is no target, it is no joint with one degree of freedom, or a number is negative.
    """
    by_joint: dict[str, list[BuiltDof]] = {}
    for built in dofs:
        by_joint.setdefault(built.joint.path, []).append(built)
    for prim in parsed.prims:
        if str(prim.GetTypeName()) == KIND:
            _add(parsed, spec, names, prim, by_joint)


def _add(
    parsed: ParsedStage, spec: mujoco.MjSpec, names: Names, prim: Usd.Prim, by_joint: dict[str, list[BuiltDof]]
) -> None:
    path, schemas = prim.GetPath(), applied_schemas(prim)
    targets = targets_of(prim, "newton:targets")
    if not targets:
        raise parsed.fail(prim, "newton:targets", "an actuator needs a joint to drive")
    if len(by_joint.get(targets[0], ())) != 1:
        raise parsed.fail(prim, "newton:targets", f"<{targets[0]}> is no joint with one degree of freedom")
    if len(targets) > 1:
        parsed.report.ignore(path, "newton:targets", "an actuator drives its first target only")
    laws = [law for law in _LAWS if law in schemas]
    if not laws or "NewtonNeuralControlAPI" in laws:
        reason = "a neural control law is not evaluated" if laws else "an actuator without a control law"
        parsed.report.ignore(path, laws[0] if laws else KIND, reason)
        return
    built = by_joint[targets[0]][0]
    angular = built.dof.angular
    effort = parsed.units.factor("effort", angular)
    gain = parsed.units.factor("gain_rad", angular)
    kp, kd = (_positive(parsed, prim, name, 0.0) * gain for name in ("kp", "kd"))
    constant = float(value_of(prim, "newton:constEffort") or 0.0) * effort
    bound = _bound(parsed, prim, schemas, built) * effort
    for name, reason in (
        ("ki", "PD actuators have no integral"),
        ("delaySteps", "commands are not delayed"),
    ):
        if value_of(prim, f"newton:{name}"):
            parsed.report.ignore(path, f"newton:{name}", reason)
    if bound == 0.0:
        return  # it cannot push, like a drive whose maxForce is 0
    actuator = spec.add_actuator(
        name=names.of("actuator", str(path)), target=built.name, trntype=mujoco.mjtTrn.mjTRN_JOINT
    )
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    # Without stiffness the command is a velocity.
    actuator.gainprm = [kp or kd] + [0.0] * (len(actuator.gainprm) - 1)
    actuator.biasprm = [constant, -kp, -kd] + [0.0] * (len(actuator.biasprm) - 3)
    if bound < UNBOUNDED:
        actuator.forcerange = [-bound, bound]
        actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
    parsed.report.took("actuator", "newton")


def _positive(parsed: ParsedStage, prim: Usd.Prim, name: str, default: float) -> float:
    value = value_of(prim, f"newton:{name}")
    if value is None:
        return default
    if value < 0:
        raise parsed.fail(prim, f"newton:{name}", f"must not be negative, is {value:g}")
    return float(value)


def _bound(parsed: ParsedStage, prim: Usd.Prim, schemas: list[str], built: BuiltDof) -> float:
    """Largest effort at rest that all clamping schemas allow, in the stage's units."""
    path, bound = prim.GetPath(), math.inf
    if "NewtonMaxEffortClampingAPI" in schemas:
        bound = _positive(parsed, prim, "maxEffort", math.inf)
    if "NewtonDCMotorClampingAPI" in schemas:
        stall = _positive(parsed, prim, "saturationEffort", math.inf)
        bound = min(bound, stall, _positive(parsed, prim, "maxMotorEffort", math.inf))
        speed = _positive(parsed, prim, "velocityLimit", math.inf)
        if speed < UNBOUNDED:
            unit = 1.0 if built.dof.angular else parsed.units.length
            parsed.report.joint_velocity_limits.setdefault(built.name, speed * unit)
            reason = "the effort at stall bounds at any speed; DCMotorCfg has the whole curve"
            parsed.report.approximate(path, "newton:saturationEffort", reason)
    if "NewtonPositionBasedClampingAPI" in schemas:
        efforts = np.asarray(value_of(prim, "newton:lookupEfforts") or [], dtype=float)
        positions = value_of(prim, "newton:lookupPositions") or []
        if not len(efforts) or len(efforts) != len(positions) or (efforts < 0).any():
            reason = "needs as many efforts, of at least zero, as lookupPositions"
            raise parsed.fail(prim, "newton:lookupEfforts", reason)
        bound = min(bound, float(efforts.max()))
        reason = "the largest effort of the table bounds at any position"
        parsed.report.approximate(path, "newton:lookupEfforts", reason)
    return bound
