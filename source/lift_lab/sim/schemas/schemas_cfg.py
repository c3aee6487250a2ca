"""Physics properties that a spawner may set on its asset (names of Isaac Lab's schema configs).

None keeps the USD file's value. What MuJoCo has no counterpart for is listed once as ignored.
"""

from __future__ import annotations

from typing import ClassVar, Literal

from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.ranges import COUNT_OR_ZERO, FINITE, NOT_NEGATIVE, NOT_NEGATIVE_OR_INF, Ranges


@configclass
class ArticulationRootPropertiesCfg(ConfigBase):
    """Properties of an articulation's root."""

    articulation_enabled: bool | None = None
    """Ignored: every articulation is simulated."""
    enabled_self_collisions: bool | None = None
    """Whether links of the articulation collide with each other."""
    solver_position_iteration_count: int | None = None
    """Ignored: PhysX solver setting; MuJoCo's are in sim.mujoco."""
    solver_velocity_iteration_count: int | None = None
    """Ignored: PhysX solver setting; MuJoCo's are in sim.mujoco."""
    sleep_threshold: float | None = None
    """Ignored: MuJoCo worlds do not sleep."""
    stabilization_threshold: float | None = None
    """Ignored: MuJoCo worlds do not sleep."""
    fix_root_link: bool | None = None
    """True fixes the root link to the world; False frees it."""

    _ranges: ClassVar[Ranges] = {
        "solver_position_iteration_count solver_velocity_iteration_count": COUNT_OR_ZERO,
        "sleep_threshold stabilization_threshold": NOT_NEGATIVE,
    }


@configclass
class RigidBodyPropertiesCfg(ConfigBase):
    """Properties of every rigid body of the asset."""

    rigid_body_enabled: bool | None = None
    """Ignored: every rigid body is simulated."""
    kinematic_enabled: bool | None = None
    """Whether the body is moved by its user only (a mocap body)."""
    disable_gravity: bool | None = None
    """Whether gravity is compensated on the bodies."""
    linear_damping: float | None = None
    """Ignored: MuJoCo has no damping of free bodies; see joint damping."""
    angular_damping: float | None = None
    """Ignored: MuJoCo has no damping of free bodies; see joint damping."""
    max_linear_velocity: float | None = None
    """Ignored: MuJoCo does not clamp velocities."""
    max_angular_velocity: float | None = None
    """Ignored: MuJoCo does not clamp velocities."""
    max_depenetration_velocity: float | None = None
    """Ignored: set by the contact's solref."""
    max_contact_impulse: float | None = None
    """Ignored: MuJoCo does not clamp impulses."""
    enable_gyroscopic_forces: bool | None = None
    """Ignored: always on."""
    retain_accelerations: bool | None = None
    """Ignored: accelerations are always kept."""
    solver_position_iteration_count: int | None = None
    """Ignored: PhysX solver setting; MuJoCo's are in sim.mujoco."""
    solver_velocity_iteration_count: int | None = None
    """Ignored: PhysX solver setting; MuJoCo's are in sim.mujoco."""
    sleep_threshold: float | None = None
    """Ignored: MuJoCo worlds do not sleep."""
    stabilization_threshold: float | None = None
    """Ignored: MuJoCo worlds do not sleep."""

    _ranges: ClassVar[Ranges] = {
        "linear_damping angular_damping sleep_threshold stabilization_threshold": NOT_NEGATIVE,
        "max_linear_velocity max_angular_velocity max_depenetration_velocity max_contact_impulse": NOT_NEGATIVE_OR_INF,
        "solver_position_iteration_count solver_velocity_iteration_count": COUNT_OR_ZERO,
    }


@configclass
class CollisionPropertiesCfg(ConfigBase):
    """Properties of every collider of the asset."""

    collision_enabled: bool | None = None
    """Whether the colliders collide."""
    contact_offset: float | None = None
    """Ignored: MuJoCo finds contacts without a lookahead distance."""
    rest_offset: float | None = None
    """Distance in m at which two surfaces rest (MuJoCo's margin)."""
    torsional_patch_radius: float | None = None
    """Ignored: torsional friction is a material's friction[1]."""
    min_torsional_patch_radius: float | None = None
    """Ignored: torsional friction is a material's friction[1]."""

    _ranges: ClassVar[Ranges] = {
        "contact_offset rest_offset": FINITE,
        "torsional_patch_radius min_torsional_patch_radius": NOT_NEGATIVE,
    }


@configclass
class MassPropertiesCfg(ConfigBase):
    """Mass or density of every rigid body of the asset."""

    mass: float | None = None
    """Mass in kg. The inertia is scaled with it."""
    density: float | None = None
    """Density of the colliders in kg/m^3, used when :attr:`mass` is None."""

    _ranges: ClassVar[Ranges] = {"mass density": NOT_NEGATIVE}


@configclass
class JointDrivePropertiesCfg(ConfigBase):
    """Properties of every joint drive of the asset."""

    drive_type: Literal["force", "acceleration"] | None = None
    """Ignored: set in the USD file."""
    max_effort: float | None = None
    """Largest force (N) or torque (N m)."""
    max_velocity: float | None = None
    """Ignored: MuJoCo has no joint velocity limit."""
    stiffness: float | None = None
    """Stiffness in N/m or N m/rad."""
    damping: float | None = None
    """Damping in N s/m or N m s/rad."""

    _ranges: ClassVar[Ranges] = {"max_effort max_velocity": NOT_NEGATIVE_OR_INF, "stiffness damping": NOT_NEGATIVE}


@configclass
class FixedTendonPropertiesCfg(ConfigBase):
    """Properties of PhysX fixed tendons: accepted, and ignored."""

    tendon_enabled: bool | None = None
    stiffness: float | None = None
    damping: float | None = None
    limit_stiffness: float | None = None
    offset: float | None = None
    rest_length: float | None = None

    _ranges: ClassVar[Ranges] = {"stiffness damping limit_stiffness": NOT_NEGATIVE, "offset rest_length": FINITE}


@configclass
class SpatialTendonPropertiesCfg(ConfigBase):
    """Properties of PhysX spatial tendons: accepted, and ignored."""

    tendon_enabled: bool | None = None
    stiffness: float | None = None
    damping: float | None = None
    limit_stiffness: float | None = None
    offset: float | None = None

    _ranges: ClassVar[Ranges] = {"stiffness damping limit_stiffness": NOT_NEGATIVE, "offset": FINITE}


@configclass
class DeformableBodyPropertiesCfg(ConfigBase):
    """Makes a body deformable. Fields for PhysX's mesh and solver have no effect: see
    :mod:`lift_lab.usd.deformable`."""

    deformable_enabled: bool | None = None
    kinematic_enabled: bool = False
    self_collision: bool | None = None
    self_collision_filter_distance: float | None = None
    settling_threshold: float | None = None
    sleep_damping: float | None = None
    sleep_threshold: float | None = None
    solver_position_iteration_count: int | None = None
    vertex_velocity_damping: float | None = None
    simulation_hexahedral_resolution: int = 10
    collision_simplification: bool = True
    collision_simplification_remeshing: bool = True
    collision_simplification_remeshing_resolution: int = 0
    collision_simplification_target_triangle_count: int = 0
    collision_simplification_force_conforming: bool = True
    contact_offset: float | None = None
    rest_offset: float | None = None
    max_depenetration_velocity: float | None = None

    _ranges: ClassVar[Ranges] = {
        (
            "self_collision_filter_distance settling_threshold sleep_damping sleep_threshold vertex_velocity_damping"
        ): NOT_NEGATIVE,
        (
            "solver_position_iteration_count simulation_hexahedral_resolution "
            "collision_simplification_remeshing_resolution "
            "collision_simplification_target_triangle_count"
        ): COUNT_OR_ZERO,
        "contact_offset rest_offset": FINITE,
        "max_depenetration_velocity": NOT_NEGATIVE_OR_INF,
    }
