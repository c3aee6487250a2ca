"""From actuator configs to the spec's actuators: gains, limits, armature and friction of every driven joint.

Each driven joint has one engine actuator. Implicit: effort = kp (ctrl - q) - kd qd with ctrl in joint units.
Explicit: effort = ctrl.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass, field

import mujoco
import numpy as np

from lift_lab.actuators import ActuatorBaseCfg
from lift_lab.sim.ignored import note_ignored
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.string import resolve_matching_names, resolve_matching_names_values

logger = logging.getLogger(__name__)

_SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass
class JointDrive:
    """What one joint's actuator was resolved to. Units: N m (N), rad (m), s."""

    joint: str
    group: str | None
    implicit: bool
    stiffness: float
    damping: float
    effort_limit: float
    model_effort_limit: float
    velocity_limit: float


@dataclass
class Drives:
    """All driven joints of an articulation, and the joints of each group in config order."""

    joints: dict[str, JointDrive] = field(default_factory=dict)
    groups: dict[str, list[str]] = field(default_factory=dict)


def joint_names(spec: mujoco.MjSpec) -> list[str]:
    """Names of the hinge and slide joints in the engine's order."""
    return [joint.name for body in spec.bodies for joint in body.joints if joint.type in _SCALAR]


def _resolve(value: dict[str, float] | float | None, names: list[str], path: str) -> dict[str, float]:
    """Value of each joint that ``value`` names; a number holds for all."""
    if value is None:
        return {}
    if isinstance(value, dict):
        try:
            _, found, values = resolve_matching_names_values(value, names)
        except ValueError as error:
            raise ConfigError(f"{path}: {error}") from error
        return dict(zip(found, values, strict=True))
    return dict.fromkeys(names, float(value))


def _usd_drive(spec: mujoco.MjSpec, joint: str) -> tuple[float, float]:
    """Gains of the joint's drive in the USD file; zeros where there is none."""
    kp = kd = 0.0
    for actuator in spec.actuators:
        if actuator.target == joint:
            kp -= float(actuator.biasprm[1])
            kd -= float(actuator.biasprm[2])
    return kp, kd


def _usd_effort_limit(joint: mujoco.MjsJoint) -> float:
    low, high = joint.actfrcrange
    return float(high) if high > low and np.isfinite(high) else float("inf")


def build_drives(
    spec: mujoco.MjSpec, actuators: dict[str, ActuatorBaseCfg], velocity_limits: dict[str, float], path: str
) -> Drives:
    """Replace the spec's actuators by what the actuator configs say.

    Joints that no group names keep their USD drive.

    Args:
        spec: the articulation, changed in place.
        actuators: group name -> config.
        velocity_limits: joint name -> velocity limit in the USD file (rad/s or m/s).
        path: where the articulation is configured, for messages.

    Raises:
        ConfigError: a pattern that matches no joint, or a joint in two groups.
    """
    names = joint_names(spec)
    specs = {joint.name: joint for joint in spec.joints if joint.type in _SCALAR}
    drives = Drives()
    for group, cfg in actuators.items():
        where = f"{path}.actuators['{group}']"
        try:
            _, chosen = resolve_matching_names(cfg.joint_names_expr, names)
        except ValueError as error:
            raise ConfigError(f"{where}.joint_names_expr: {error}") from error
        taken = [name for name in chosen if name in drives.joints]
        if taken:
            raise ConfigError(f"{where}: joint '{taken[0]}' is already driven by '{drives.joints[taken[0]].group}'")
        drives.groups[group] = chosen
        _build_group(spec, specs, cfg, group, chosen, velocity_limits, where, drives)
    left = [name for name in names if name not in drives.joints]
    for name in left:
        kp, kd = _usd_drive(spec, name)
        if kp == 0.0 and kd == 0.0:
            continue
        limit = _usd_effort_limit(specs[name])
        drives.joints[name] = JointDrive(
            name, None, True, kp, kd, limit, limit, velocity_limits.get(name, float("inf"))
        )
        logger.warning("%s: joint '%s' is in no actuator group; its USD drive is used", path, name)
    for actuator in list(spec.actuators):
        if actuator.target in drives.joints:
            spec.delete(actuator)
    for name in names:
        if name in drives.joints:
            _add_actuator(spec, specs[name], drives.joints[name])
    return drives


def _build_group(
    spec: mujoco.MjSpec,
    specs: dict[str, mujoco.MjsJoint],
    cfg: ActuatorBaseCfg,
    group: str,
    chosen: list[str],
    velocity_limits: dict[str, float],
    where: str,
    drives: Drives,
) -> None:
    def resolve(field_name: str) -> dict[str, float]:
        return _resolve(getattr(cfg, field_name), chosen, f"{where}.{field_name}")

    implicit = cfg.class_type.is_implicit_model
    stiffness, damping = resolve("stiffness"), resolve("damping")
    effort, effort_sim = resolve("effort_limit"), resolve("effort_limit_sim")
    velocity = resolve("velocity_limit_sim") | resolve("velocity_limit")
    armature, friction, viscous = resolve("armature"), resolve("friction"), resolve("viscous_friction")
    if implicit and cfg.velocity_limit_sim is not None:
        note_ignored(f"{where}.velocity_limit_sim", "MuJoCo does not clamp joint velocities; kept in joint_vel_limits")
    if cfg.dynamic_friction is not None:
        note_ignored(f"{where}.dynamic_friction", "MuJoCo has one dry friction: 'friction'")
    for name in chosen:
        joint = specs[name]
        usd_kp, usd_kd = _usd_drive(spec, name)
        usd_limit = _usd_effort_limit(joint)
        if implicit:
            limit = effort_sim.get(name, effort.get(name, usd_limit))
            model_limit = limit
        else:
            limit = effort_sim.get(name, float("inf"))
            model_limit = effort.get(name, usd_limit)
        drives.joints[name] = JointDrive(
            joint=name,
            group=group,
            implicit=implicit,
            stiffness=stiffness.get(name, usd_kp),
            damping=damping.get(name, usd_kd),
            effort_limit=limit,
            model_effort_limit=model_limit,
            velocity_limit=velocity.get(name, velocity_limits.get(name, float("inf"))),
        )
        if name in armature:
            joint.armature = armature[name]
        if name in friction:
            joint.frictionloss = friction[name]
        if name in viscous:
            damping_terms = np.array(joint.damping, dtype=np.float64)
            joint.damping = _first(damping_terms, viscous[name])


def _first(values: np.ndarray, value: float) -> float | np.ndarray:
    """``value`` in the first entry where the engine keeps a polynomial, else itself."""
    if values.ndim == 0:
        return value
    values[:] = 0.0
    values[0] = value
    return values


def _add_actuator(spec: mujoco.MjSpec, joint: mujoco.MjsJoint, drive: JointDrive) -> None:
    actuator = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    if drive.implicit:
        actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        actuator.gainprm[0] = drive.stiffness if drive.stiffness else 1.0
        actuator.biasprm[1] = -drive.stiffness
        actuator.biasprm[2] = -drive.damping
    else:
        actuator.biastype = mujoco.mjtBias.mjBIAS_NONE
        actuator.gainprm[0] = 1.0
    actuator.ctrllimited = False
    joint.actfrclimited = False
    joint.actfrcrange = [0, 0]
    if np.isfinite(drive.effort_limit):
        actuator.forcelimited = True
        actuator.forcerange = [-drive.effort_limit, drive.effort_limit]
