"""Write schema configs into a spawned asset's MjSpec."""

from __future__ import annotations

import itertools

import mujoco

from lift_lab.usd.filters import SELF_COLLISION
from lift_lab.utils.errors import ConfigError

from ..ignored import note_ignored_fields
from . import schemas_cfg as cfgs

_SOLVER = "PhysX solver setting; MuJoCo's are in sim.mujoco"
_SLEEP = "MuJoCo worlds do not sleep"

_ARTICULATION = {
    "articulation_enabled": "every articulation is simulated",
    "solver_position_iteration_count": _SOLVER,
    "solver_velocity_iteration_count": _SOLVER,
    "sleep_threshold": _SLEEP,
    "stabilization_threshold": _SLEEP,
}
_RIGID = {
    "rigid_body_enabled": "every rigid body is simulated",
    "linear_damping": "MuJoCo has no damping of free bodies; see joint damping",
    "angular_damping": "MuJoCo has no damping of free bodies; see joint damping",
    "max_linear_velocity": "MuJoCo does not clamp velocities",
    "max_angular_velocity": "MuJoCo does not clamp velocities",
    "max_depenetration_velocity": "set by the contact's solref",
    "max_contact_impulse": "MuJoCo does not clamp impulses",
    "enable_gyroscopic_forces": "always on",
    "retain_accelerations": "accelerations are always kept",
    "solver_position_iteration_count": _SOLVER,
    "solver_velocity_iteration_count": _SOLVER,
    "sleep_threshold": _SLEEP,
    "stabilization_threshold": _SLEEP,
}
_COLLISION = {
    "contact_offset": "MuJoCo finds contacts without a lookahead distance",
    "torsional_patch_radius": "torsional friction is a material's friction[1]",
    "min_torsional_patch_radius": "torsional friction is a material's friction[1]",
}
_TENDON: dict[str, str] = dict.fromkeys(
    ("tendon_enabled", "stiffness", "damping", "limit_stiffness", "offset", "rest_length"),
    "PhysX tendons have no counterpart",
)


def _bodies(spec: mujoco.MjSpec) -> list[mujoco.MjsBody]:
    return [body for body in spec.bodies if body.name != "world"]


def _colliders(spec: mujoco.MjSpec) -> list[mujoco.MjsGeom]:
    return [geom for geom in spec.geoms if geom.contype or geom.conaffinity]


def _roots(spec: mujoco.MjSpec) -> list[mujoco.MjsBody]:
    return list(spec.worldbody.bodies)


def _set_self_collisions(spec: mujoco.MjSpec, enabled: bool) -> None:
    """Let links collide with each other, or not; bodies that a joint or a filter keeps apart stay apart."""
    names = {body.name for body in _bodies(spec)}
    for exclude in list(spec.excludes):
        if exclude.name.startswith(SELF_COLLISION):
            spec.delete(exclude)
    if enabled:
        return
    apart = {frozenset((exclude.bodyname1, exclude.bodyname2)) for exclude in spec.excludes}
    for body1, body2 in itertools.combinations(sorted(names), 2):
        if frozenset((body1, body2)) not in apart:
            spec.add_exclude(name=f"{SELF_COLLISION}{body1}:{body2}", bodyname1=body1, bodyname2=body2)


def _set_fixed(spec: mujoco.MjSpec, fixed: bool) -> None:
    for body in _roots(spec):
        free = [joint for joint in body.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
        if fixed:
            for joint in free:
                spec.delete(joint)
        elif not free and not body.joints:
            body.add_freejoint(name=body.name)


def _set_kinematic(spec: mujoco.MjSpec, kinematic: bool) -> None:
    if not kinematic:
        return
    _set_fixed(spec, True)
    for body in _roots(spec):
        body.mocap = True


def _set_mass(spec: mujoco.MjSpec, cfg: cfgs.MassPropertiesCfg, path: str) -> None:
    if cfg.mass is None and cfg.density is None:
        return
    value = cfg.mass if cfg.mass is not None else cfg.density
    if not value or value < 0:
        raise ConfigError(f"{path}: mass and density must be positive, got {value}")
    blank = mujoco.MjSpec().worldbody.add_body()
    for body in _bodies(spec):
        colliders = [g for g in body.geoms if g.contype or g.conaffinity]
        if cfg.mass is None:
            if not colliders:
                continue
            # a mass that stays behind would count as explicit: put back everything as it is in a new body
            for field in ("mass", "inertia", "ipos", "iquat", "fullinertia", "explicitinertial"):
                setattr(body, field, getattr(blank, field))
            for geom in body.geoms:
                geom.mass = float("nan")
                geom.density = cfg.density if geom in colliders else 0.0
        elif body.explicitinertial:
            scale = cfg.mass / body.mass if body.mass > 0 else 1.0
            body.mass = cfg.mass
            body.inertia = body.inertia * scale
            body.fullinertia = body.fullinertia * scale
        elif colliders:
            # the colliders share the mass by volume: densities are scaled by what they weigh at 1 kg/m^3
            volume = 0.0
            for geom in colliders:
                geom.mass, geom.density = float("nan"), 1.0
            for geom in body.geoms:
                if geom not in colliders:
                    geom.mass, geom.density = float("nan"), 0.0
            volume = float(spec.copy().compile().body(body.name).mass[0])
            for geom in colliders:
                geom.density = cfg.mass / volume
        else:
            raise ConfigError(f"{path}: body '{body.name}' has no collider whose mass could be set")


def _set_drives(spec: mujoco.MjSpec, cfg: cfgs.JointDrivePropertiesCfg) -> None:
    """Give the joints' drives other gains and limits; actuators of another kind (motors) keep their gains.

    A drive is a position actuator, a velocity actuator, or a position actuator with a second one that carries the
    target velocity (:mod:`lift_lab.usd.drives`). Gains are of the joint: a gear counts twice in them.
    """
    kinds = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    positions = {actuator.target for actuator in spec.actuators if actuator.biasprm[1]}
    for actuator in spec.actuators:
        of_joint = actuator.trntype in kinds
        if cfg.max_effort is not None and of_joint:  # the joint's own range holds instead
            actuator.forcerange, actuator.forcelimited = [0, 0], mujoco.mjtLimited.mjLIMITED_FALSE
        gear = float(actuator.gear[0]) if of_joint else 1.0
        stiffness, damping = (None if g is None else g / gear**2 for g in (cfg.stiffness, cfg.damping))
        carries_velocity = actuator.name == f"{actuator.target}_velocity" and actuator.target in positions
        if carries_velocity:
            if damping is not None:
                actuator.gainprm[0] = damping
            continue
        if not actuator.biasprm[1] and not actuator.biasprm[2]:
            continue
        if damping is not None:
            actuator.biasprm[2] = -damping
            if not actuator.biasprm[1]:
                actuator.gainprm[0] = damping
        if stiffness or (stiffness is not None and actuator.biasprm[1]):
            actuator.gainprm[0] = stiffness
            actuator.biasprm[1] = -stiffness
    if cfg.max_effort is not None:
        for joint in spec.joints:
            if joint.type in (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE):
                joint.actfrcrange = [-cfg.max_effort, cfg.max_effort]
                joint.actfrclimited = True


def apply_schemas(spec: mujoco.MjSpec, spawn: object, path: str) -> None:
    """Apply the property configs of a spawner (``rigid_props``, ``mass_props``, ...) to the spawned spec.

    Args:
        spec: the asset, changed in place.
        spawn: a spawner config; the fields it has are used.
        path: where the spawner is configured, for messages, e.g. ``"scene.robot.spawn"``.

    Raises:
        ConfigError: a mass or density that is not positive, or cannot be set.
    """
    rigid = getattr(spawn, "rigid_props", None)
    if rigid is not None:
        note_ignored_fields(f"{path}.rigid_props", rigid, _RIGID)
        if rigid.disable_gravity is not None:
            for body in _bodies(spec):
                body.gravcomp = 1.0 if rigid.disable_gravity else 0.0
        if rigid.kinematic_enabled is not None:
            _set_kinematic(spec, rigid.kinematic_enabled)
    collision = getattr(spawn, "collision_props", None)
    if collision is not None:
        note_ignored_fields(f"{path}.collision_props", collision, _COLLISION)
        for geom in _colliders(spec):
            if collision.collision_enabled is False:
                geom.contype = geom.conaffinity = 0
            if collision.rest_offset is not None:
                geom.margin = collision.rest_offset
    mass = getattr(spawn, "mass_props", None)
    if mass is not None:
        _set_mass(spec, mass, f"{path}.mass_props")
    articulation = getattr(spawn, "articulation_props", None)
    if articulation is not None:
        note_ignored_fields(f"{path}.articulation_props", articulation, _ARTICULATION)
        if articulation.enabled_self_collisions is not None:
            _set_self_collisions(spec, articulation.enabled_self_collisions)
        if articulation.fix_root_link is not None:
            _set_fixed(spec, articulation.fix_root_link)
    drives = getattr(spawn, "joint_drive_props", None)
    if drives is not None:
        note_ignored_fields(
            f"{path}.joint_drive_props",
            drives,
            {"max_velocity": "MuJoCo has no joint velocity limit", "drive_type": "set in the USD file"},
        )
        _set_drives(spec, drives)
    for tendon in ("fixed_tendons_props", "spatial_tendons_props"):
        if getattr(spawn, tendon, None) is not None:
            note_ignored_fields(f"{path}.{tendon}", getattr(spawn, tendon), _TENDON)
