"""The drives that an asset's own file gives its joints, as MuJoCo compiles them, in units of the joints.

A drive in MuJoCo is any number of actuators, each with a gear, a gain, a bias and limits of its own. At the joint,
those that follow a PD law add up to

    effort = stiffness * (target - q) - damping * qd + constant, within an effort range.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field

import mujoco
import numpy as np

from lift_lab.utils.errors import ConfigError, quote

logger = logging.getLogger(__name__)

_INF = float("inf")
_OF_JOINTS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
_SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass(frozen=True)
class FileDrive:
    """Drive of one joint in its file. Units: N m (N), rad (m), s."""

    stiffness: float = 0.0
    damping: float = 0.0
    constant: float = 0.0
    """Effort at zero target, position and velocity."""
    effort_range: tuple[float, float] = (-_INF, _INF)
    """Least and greatest effort of all actuators together."""
    position_range: tuple[float, float] = (-_INF, _INF)
    """Range to which the file clips position targets (the control range of a position actuator)."""
    velocity_range: tuple[float, float] = (-_INF, _INF)
    """Range to which the file clips velocity targets (the control range of a velocity actuator)."""
    actuators: tuple[str, ...] = ()
    """Names of the actuators that follow the law above, in the file."""
    others: tuple[str, ...] = ()
    """Names of the joint's actuators that follow another law."""

    @property
    def effort_limit(self) -> float:
        """Greatest effort to either side."""
        return max(abs(side) for side in self.effort_range)


@dataclass
class _Sum:
    stiffness: float = 0.0
    damping: float = 0.0
    constant: float = 0.0
    low: float = 0.0
    high: float = 0.0
    position_range: tuple[float, float] = (-_INF, _INF)
    velocity_range: tuple[float, float] = (-_INF, _INF)
    actuators: list[str] = field(default_factory=list)
    others: list[str] = field(default_factory=list)


def read_file_drives(spec: mujoco.MjSpec, loop_drives: Mapping[str, str], path: str) -> dict[str, FileDrive]:
    """Drives of all hinges and slides, from a compile of the asset.

    The compiled model has numbers where the file may have none: damping ratios, inherited and automatic ranges.

    Args:
        spec: the asset; not changed.
        loop_drives: joint by actuator name, for drives between the two bodies of a joint that closes a loop.
        path: where the asset is configured, for messages.

    Raises:
        ConfigError: MuJoCo cannot compile the asset.
    """
    alone = spec.copy()
    for key in list(alone.keys):  # one may not fit after the spawner's overrides
        alone.delete(key)
    try:
        model = alone.compile()
    except ValueError as error:
        raise ConfigError(f"{path}: MuJoCo cannot compile the asset: {error}") from error
    sums: dict[str, _Sum] = {}
    for a in range(model.nu):
        name = model.actuator(a).name
        joint = loop_drives.get(name) or _joint_of(model, a)
        if joint is not None:
            gear = 1.0 if name in loop_drives else float(model.actuator_gear[a, 0])
            _add(model, a, gear, sums.setdefault(joint, _Sum()))
    return {name: _at_joint(model, name, sums.get(name), path) for name in _scalar_joints(model)}


def _scalar_joints(model: mujoco.MjModel) -> list[str]:
    return [model.joint(j).name for j in range(model.njnt) if int(model.jnt_type[j]) in {int(t) for t in _SCALAR}]


def _joint_of(model: mujoco.MjModel, a: int) -> str | None:
    """The hinge or slide that an actuator drives directly."""
    joint = int(model.actuator_trnid[a, 0])
    if int(model.actuator_trntype[a]) not in {int(t) for t in _OF_JOINTS}:
        return None
    return model.joint(joint).name if int(model.jnt_type[joint]) in {int(t) for t in _SCALAR} else None


def _follows_pd_law(model: mujoco.MjModel, a: int) -> bool:
    bias = model.actuator_biastype[a]
    affine = bias == int(mujoco.mjtBias.mjBIAS_AFFINE)
    return bool(
        model.actuator_dyntype[a] == int(mujoco.mjtDyn.mjDYN_NONE)
        and model.actuator_gaintype[a] == int(mujoco.mjtGain.mjGAIN_FIXED)
        and (affine or bias == int(mujoco.mjtBias.mjBIAS_NONE))
        and not (affine and (model.actuator_biasprm[a, 1:3] > 0).any())
        and not model.actuator_delay[a]
        and not model.actuator_damping[a]
        and not model.actuator_armature[a]
    )


def _add(model: mujoco.MjModel, a: int, gear: float, total: _Sum) -> None:
    """Add an actuator to the drive of its joint: lengths and velocities are the joint's times the gear."""
    name = model.actuator(a).name
    if not _follows_pd_law(model, a):
        total.others.append(name)
        return
    total.actuators.append(name)
    bias = np.zeros(3)
    if model.actuator_biastype[a] == int(mujoco.mjtBias.mjBIAS_AFFINE):
        bias[:] = model.actuator_biasprm[a, :3]
    stiffness, damping = -bias[1] * gear**2, -bias[2] * gear**2
    total.stiffness += float(stiffness)
    total.damping += float(damping)
    total.constant += float(bias[0] * gear)
    low, high = -_INF, _INF
    if model.actuator_forcelimited[a]:
        low, high = sorted(float(f * gear) for f in model.actuator_forcerange[a])
    if model.actuator_ctrllimited[a]:
        efforts = sorted(float(c * model.actuator_gainprm[a, 0] * gear) for c in model.actuator_ctrlrange[a])
        if stiffness > 0:
            total.position_range = (efforts[0] / stiffness, efforts[1] / stiffness)
        elif damping > 0:
            total.velocity_range = (efforts[0] / damping, efforts[1] / damping)
        else:
            low, high = max(low, efforts[0] + bias[0] * gear), min(high, efforts[1] + bias[0] * gear)
    total.low += low
    total.high += high


def _at_joint(model: mujoco.MjModel, name: str, total: _Sum | None, path: str) -> FileDrive:
    joint = model.joint(name).id
    low, high = -_INF, _INF
    if model.jnt_actfrclimited[joint]:
        low, high = (float(f) for f in model.jnt_actfrcrange[joint])
    if total is None:
        return FileDrive(effort_range=(low, high))
    if total.actuators:
        bounded = len(total.actuators) > 1 and np.isfinite([total.low, total.high]).any()
        if bounded:
            logger.warning(
                "%s: joint '%s' has the actuators %s: one drive takes their place, with their gains and force ranges"
                " added up; MuJoCo clips each by its own",
                path,
                name,
                quote(total.actuators),
            )
        low, high = max(low, total.low), min(high, total.high)
    return FileDrive(
        stiffness=total.stiffness,
        damping=total.damping,
        constant=total.constant,
        effort_range=(low, high),
        position_range=total.position_range,
        velocity_range=total.velocity_range,
        actuators=tuple(total.actuators),
        others=tuple(total.others),
    )
