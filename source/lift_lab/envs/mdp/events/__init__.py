"""Event terms, with Isaac Lab's names: what happens to the scene at start-up, at a reset or now and then.

Each is called as ``term(env, env_ids, **params)``; ``env_ids`` is None for all environments.
"""

from .disturbances import apply_external_force_torque, push_by_setting_velocity
from .randomization import (
    randomize_actuator_gains,
    randomize_joint_parameters,
    randomize_physics_scene_gravity,
    randomize_rigid_body_collider_offsets,
    randomize_rigid_body_com,
    randomize_rigid_body_mass,
    randomize_rigid_body_material,
    scale_friction,
)
from .resets import (
    reset_joints_by_offset,
    reset_joints_by_scale,
    reset_nodal_state_outside,
    reset_nodal_state_uniform,
    reset_root_state_outside,
    reset_root_state_uniform,
    reset_root_state_with_random_orientation,
    reset_scene_to_default,
)
