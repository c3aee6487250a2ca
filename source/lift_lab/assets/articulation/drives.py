"""From actuator configs to the spec's actuators: gains, limits, armature and friction of every driven joint.

Each driven joint has one engine actuator. Implicit: effort = kp (ctrl - q) - kd qd + constant with ctrl in joint units.
Explicit: effort = ctrl.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np

from lift_lab.actuators import ActuatorBase, ActuatorBaseCfg, ImplicitActuator
from lift_lab.sim.ignored import note_ignored
from lift_lab.usd import ImportReport
from lift_lab.utils.errors import ConfigError, quote
from lift_lab.utils.string import resolve_matching_names, resolve_matching_names_values

from .file_drives import FileDrive, read_file_drives

logger = logging.getLogger(__name__)

_SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
_JOINT = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
NO_LIMIT = 1.0e9
"""Force range of an actuator without a limit, in N m or N: Isaac Lab's number."""
_GAINS = ("stiffness", "damping", "armature", "friction", "viscous_friction")
_LIMITS = ("effort_limit", "effort_limit_sim", "velocity_limit", "velocity_limit_sim")


@dataclass(frozen=True)
class FileJoint:
    """Properties of a joint in its file, before any config. Units: N m (N), rad (m), s."""

    drive: FileDrive
    armature: float
    friction: float
    viscous_friction: float
    velocity_limit: float


@dataclass
class JointDrive:
    """Resolved actuator of one joint. Units: N m (N), rad (m), s."""

    joint: str
    group: str | None
    implicit: bool
    stiffness: float
    damping: float
    effort_range: tuple[float, float]
    """Range of the effort that the engine's actuator gives."""
    file: FileJoint
    always_limited: bool
    """Whether the engine's actuator has a force range even where there is no limit, for a model of the user's own."""
    law: FileDrive | None
    """The file's drive, where at least one gain is the file's: its constant and its ranges of targets hold, too."""

    @property
    def effort_limit(self) -> float:
        """Greatest effort to either side."""
        return max(abs(side) for side in self.effort_range)


@dataclass
class Drives:
    """All driven joints of an articulation, and the joints of each group in config order."""

    joints: dict[str, JointDrive] = field(default_factory=dict)
    groups: dict[str, list[str]] = field(default_factory=dict)


def joint_names(spec: mujoco.MjSpec) -> list[str]:
    """Names of the hinge and slide joints in the engine's order."""
    return [joint.name for body in spec.bodies for joint in body.joints if joint.type in _SCALAR]


def build_drives(
    spec: mujoco.MjSpec, actuators: dict[str, ActuatorBaseCfg], report: ImportReport | None, path: str
) -> Drives:
    """Replace the spec's actuators by those of the actuator configs.

    Joints that no group names keep the drive of their file.

    Args:
        spec: the articulation, changed in place.
        actuators: group name -> config.
        report: the importer's report on the file, or None.
        path: where the articulation is configured, for messages.

    Raises:
        ConfigError: a pattern matches no joint, a joint is in two groups, a number is out of range, or limits
            contradict each other. Also gains that are None while the file's actuator follows no PD law.
    """
    builder = _Builder(spec, report, path)
    for group, cfg in actuators.items():
        builder.add_group(group, cfg)
    builder.add_left_over()
    builder.replace_actuators()
    return builder.drives


class _Builder:
    """Resolves the drives of one articulation."""

    def __init__(self, spec: mujoco.MjSpec, report: ImportReport | None, path: str):
        self.spec, self.path = spec, path
        self.names = joint_names(spec)
        self.joints = {joint.name: joint for joint in spec.joints if joint.type in _SCALAR}
        self.drives = Drives()
        self.velocity_limits: Mapping[str, float] = report.joint_velocity_limits if report else {}
        self.loop_drives: Mapping[str, str] = report.loop_drives if report else {}
        self.file_actuators: dict[str, list[mujoco.MjsActuator]] = {}
        elsewhere = []
        for actuator in spec.actuators:
            joint = self.loop_drives.get(actuator.name)
            if joint is None and actuator.trntype in _JOINT and actuator.target in self.joints:
                joint = actuator.target
            if joint is not None:
                self.file_actuators.setdefault(joint, []).append(actuator)
            else:
                elsewhere.append(actuator.name)
        if elsewhere:
            logger.warning(
                "%s: the actuators %s of the file drive no hinge or slide but a tendon, a site or a body: no target"
                " reaches them, their control stays 0",
                path,
                quote(elsewhere),
            )
        self._read: dict[str, FileDrive] | None = None
        self._changes: list[tuple[mujoco.MjsJoint, str, float | np.ndarray]] = []

    def file_drive(self, joint: str) -> FileDrive:
        """The joint's drive in the file; compiles the asset when it is first needed."""
        if self._read is None:
            self._read = read_file_drives(self.spec, self.loop_drives, self.path)
        return self._read[joint]

    def add_group(self, group: str, cfg: ActuatorBaseCfg) -> None:
        """Resolve the joints of one actuator config."""
        where = f"{self.path}.actuators['{group}']"
        try:
            _, chosen = resolve_matching_names(cfg.joint_names_expr, self.names)
        except ValueError as error:
            raise ConfigError(f"{where}.joint_names_expr: {error}") from error
        taken = [name for name in chosen if name in self.drives.joints]
        if taken:
            owner = self.drives.joints[taken[0]].group
            raise ConfigError(f"{where}: joint '{taken[0]}' is already driven by '{owner}'")
        self.drives.groups[group] = chosen
        numbers = {name: _resolve(getattr(cfg, name), chosen, f"{where}.{name}") for name in (*_GAINS, *_LIMITS)}
        implicit = cfg.class_type.is_implicit_model
        if implicit:
            for kind in ("effort", "velocity"):
                _check_agreement(numbers[f"{kind}_limit"], numbers[f"{kind}_limit_sim"], f"{where}.{kind}_limit")
        if cfg.velocity_limit_sim is not None:
            reason = "MuJoCo does not clamp joint velocities; kept in joint_vel_limits"
            note_ignored(f"{where}.velocity_limit_sim", reason)
        elif implicit and cfg.velocity_limit is not None:
            note_ignored(f"{where}.velocity_limit", "of an explicit model; as in Isaac Lab, set velocity_limit_sim")
        if cfg.dynamic_friction is not None:
            note_ignored(f"{where}.dynamic_friction", "MuJoCo has one dry friction: 'friction'")
        for name in chosen:
            values = {key: value[name] for key, value in numbers.items() if name in value}
            self.drives.joints[name] = self._resolve_joint(name, group, cfg.class_type, values, where)

    def _resolve_joint(
        self, name: str, group: str, class_type: type[ActuatorBase], values: dict[str, float], where: str
    ) -> JointDrive:
        joint, implicit = self.joints[name], class_type.is_implicit_model
        file = self._file_joint(name, values, implicit)
        law = file.drive if "stiffness" not in values or "damping" not in values else None
        if law is not None and law.others:
            raise ConfigError(
                f"{where}: joint '{name}' has the actuators {quote(law.others)} in its file, which are no PD drives:"
                " give stiffness and damping"
            )
        limit = values.get("effort_limit_sim", values.get("effort_limit") if implicit else NO_LIMIT)
        for key, attribute in (("armature", "armature"), ("friction", "frictionloss")):
            if key in values:
                self._changes.append((joint, attribute, values[key]))
        if "viscous_friction" in values:
            damping = _first(np.array(joint.damping, dtype=np.float64), values["viscous_friction"])
            self._changes.append((joint, "damping", damping))
        return JointDrive(
            joint=name,
            group=group,
            implicit=implicit,
            stiffness=values.get("stiffness", file.drive.stiffness),
            damping=values.get("damping", file.drive.damping),
            effort_range=file.drive.effort_range if limit is None else (-limit, limit),
            file=file,
            always_limited=class_type is not ImplicitActuator,
            law=law,
        )

    def _file_joint(self, name: str, values: dict[str, float], implicit: bool) -> FileJoint:
        """What the file says of a joint; its drive is read only where a config leaves something to it."""
        joint = self.joints[name]
        has_drive = name in self.file_actuators or bool(np.any(joint.actfrcrange))
        limited = "effort_limit" in values or (implicit and "effort_limit_sim" in values)
        given = "stiffness" in values and "damping" in values and limited
        return FileJoint(
            drive=self.file_drive(name) if has_drive and not given else FileDrive(),
            armature=float(joint.armature),
            friction=float(joint.frictionloss),
            viscous_friction=float(np.atleast_1d(joint.damping)[0]),
            velocity_limit=self.velocity_limits.get(name, math.inf),
        )

    def add_left_over(self) -> None:
        """Keep the file's drives of joints that no group names."""
        kept = []
        for name in self.names:
            if name in self.drives.joints or name not in self.file_actuators:
                continue
            file = self._file_joint(name, {}, implicit=True)
            drive = file.drive
            if drive.others:
                logger.warning(
                    "%s: joint '%s' is in no actuator group, and its actuators %s in the file are no PD drives: no"
                    " target reaches them, their control stays 0",
                    self.path,
                    name,
                    quote(drive.others),
                )
                continue
            kept.append(name)
            self.drives.joints[name] = JointDrive(
                name, None, True, drive.stiffness, drive.damping, drive.effort_range, file, False, drive
            )
        if kept:
            plural = "joint {} is in no actuator group; its USD drive is used"
            text = plural if len(kept) == 1 else "joints {} are in no actuator group; their USD drives are used"
            logger.warning("%s: %s", self.path, text.format(quote(kept)))

    def replace_actuators(self) -> None:
        """One actuator for each driven joint instead of the file's, and what the configs say of the joints."""
        for joint, attribute, value in self._changes:  # only now: a damping ratio is of the file's own armature
            setattr(joint, attribute, value)
        sites = {}
        for name in self.drives.joints:
            for actuator in self.file_actuators.get(name, ()):
                if actuator.name in self.loop_drives:
                    sites[name] = (actuator.target, actuator.refsite, np.array(actuator.gear))
                self.spec.delete(actuator)
        for name in self.names:
            if name in self.drives.joints:
                _add_actuator(self.spec, self.joints[name], self.drives.joints[name], sites.get(name))


def _resolve(value: dict[str, float] | float | None, names: list[str], path: str) -> dict[str, float]:
    """Value of each joint that ``value`` names; a number holds for all."""
    if value is None:
        return {}
    if isinstance(value, dict):
        try:
            _, found, values = resolve_matching_names_values(value, names)
        except ValueError as error:
            raise ConfigError(f"{path}: {error}") from error
        resolved = dict(zip(found, (float(v) for v in values), strict=True))
    else:
        resolved = dict.fromkeys(names, float(value))
    may_be_infinite = path.rsplit(".", 1)[-1] in _LIMITS
    for name, number in resolved.items():
        if not number >= 0 or (math.isinf(number) and not may_be_infinite):
            raise ConfigError(f"{path}: must be a number of at least 0, got {number:g} for joint '{name}'")
    return resolved


def _check_agreement(model: dict[str, float], engine: dict[str, float], path: str) -> None:
    """An implicit drive is the engine's: both limits are one."""
    for name in model:
        if name in engine and model[name] != engine[name]:
            raise ConfigError(
                f"{path} and {path.rsplit('.', 1)[-1]}_sim are one limit of an implicit actuator, and differ for joint"
                f" '{name}': {model[name]:g} and {engine[name]:g}; set only {path.rsplit('.', 1)[-1]}_sim"
            )


def _first(values: np.ndarray, value: float) -> float | np.ndarray:
    """``value`` in the first entry where the engine keeps a polynomial, else itself."""
    if values.ndim == 0:
        return value
    values[:] = 0.0
    values[0] = value
    return values


def _add_actuator(
    spec: mujoco.MjSpec,
    joint: mujoco.MjsJoint,
    drive: JointDrive,
    sites: tuple[str, str, np.ndarray] | None,
) -> None:
    actuator = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    if sites is not None:  # between the two bodies of a joint that closes a loop
        actuator.trntype = mujoco.mjtTrn.mjTRN_SITE
        actuator.target, actuator.refsite, actuator.gear = sites
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    if drive.implicit:
        actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        actuator.gainprm[0] = drive.stiffness if drive.stiffness else 1.0
        actuator.biasprm[0] = drive.law.constant if drive.law is not None else 0.0
        actuator.biasprm[1] = -drive.stiffness
        actuator.biasprm[2] = -drive.damping
    else:
        actuator.biastype = mujoco.mjtBias.mjBIAS_NONE
        actuator.gainprm[0] = 1.0
    actuator.ctrllimited = False
    joint.actfrclimited = False
    joint.actfrcrange = [0, 0]
    low, high = (min(max(side, -NO_LIMIT), NO_LIMIT) for side in drive.effort_range)
    if low == high:  # MuJoCo refuses an empty range
        high = np.nextafter(np.float32(high), np.float32(np.inf))
    if drive.always_limited or np.isfinite(drive.effort_range).any():
        actuator.forcelimited = True
        actuator.forcerange = [low, high]
