"""Terms of a Markov decision process, with Isaac Lab's names: import as ``import lift_lab.envs.mdp as mdp``.

A term is a function ``(env, **params)`` (events and curricula: ``(env, env_ids, **params)``) or a class of the same
call. A config names it; a manager calls it.
"""

from .actions import *
from .commands import *
from .curriculums import (
    anneal_reward_weight,
    anneal_reward_weight_on_success,
    modify_env_param,
    modify_reward_weight,
    modify_term_cfg,
)
from .events import *
from .observations import (
    base_ang_vel,
    base_lin_vel,
    base_pos_z,
    body_pose_w,
    body_projected_gravity_b,
    current_time_s,
    generated_commands,
    imu_ang_vel,
    imu_lin_acc,
    imu_orientation,
    imu_projected_gravity,
    joint_effort,
    joint_pos,
    joint_pos_limit_normalized,
    joint_pos_rel,
    joint_vel,
    joint_vel_rel,
    last_action,
    projected_gravity,
    remaining_time_s,
    root_ang_vel_w,
    root_lin_vel_w,
    root_pos_w,
    root_quat_w,
)
from .recorders import *
from .rewards import (
    action_l2,
    action_rate_l2,
    ang_vel_xy_l2,
    applied_torque_limits,
    base_height_l2,
    body_lin_acc_l2,
    contact_forces,
    desired_contacts,
    flat_orientation_l2,
    is_alive,
    is_terminated,
    is_terminated_term,
    joint_acc_l2,
    joint_deviation_l1,
    joint_pos_limits,
    joint_torques_l2,
    joint_vel_l1,
    joint_vel_l2,
    joint_vel_limits,
    lin_vel_z_l2,
    track_ang_vel_z_exp,
    track_lin_vel_xy_exp,
    undesired_contacts,
)
from .terminations import (
    bad_orientation,
    command_resample,
    illegal_contact,
    joint_effort_out_of_limit,
    joint_pos_out_of_limit,
    joint_pos_out_of_manual_limit,
    joint_vel_out_of_limit,
    joint_vel_out_of_manual_limit,
    root_height_below_minimum,
    time_out,
)
from .unsupported import (
    body_incoming_wrench,
    height_scan,
    image,
    image_features,
    randomize_fixed_tendon_parameters,
    randomize_rigid_body_scale,
    randomize_visual_color,
    randomize_visual_texture_material,
    reset_root_state_from_terrain,
)
