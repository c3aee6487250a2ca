"""Rotations, frames, sampling and camera geometry on batched torch tensors (Isaac Lab's ``utils.math``).

Quaternions are ``(w, x, y, z)``. The last dimension holds the vector or quaternion; leading dimensions broadcast.
Results are on the device and of the type of the inputs.
"""

from .camera import (
    convert_camera_frame_orientation_convention,
    create_rotation_matrix_from_view,
    orthogonalize_perspective_depth,
    project_points,
    unproject_depth,
)
from .frames import (
    apply_delta_pose,
    combine_frame_transforms,
    compute_pose_error,
    is_identity_pose,
    rigid_body_twist_transform,
    subtract_frame_transforms,
    transform_points,
)
from .pose_matrices import (
    generate_random_rotation,
    generate_random_transformation_matrix,
    generate_random_translation,
    interpolate_poses,
    interpolate_rotations,
    make_pose,
    pose_in_A_to_pose_in_B,
    pose_inv,
    quat_slerp,
    transform_poses_from_frame_A_to_frame_B,
    unmake_pose,
)
from .rotations import (
    axis_angle_from_quat,
    convert_quat,
    euler_xyz_from_quat,
    matrix_from_euler,
    matrix_from_quat,
    quat_apply,
    quat_apply_inverse,
    quat_apply_yaw,
    quat_box_minus,
    quat_box_plus,
    quat_conjugate,
    quat_error_magnitude,
    quat_from_angle_axis,
    quat_from_euler_xyz,
    quat_from_matrix,
    quat_inv,
    quat_mul,
    quat_rotate,
    quat_rotate_inverse,
    quat_unique,
    skew_symmetric_matrix,
    yaw_quat,
)
from .sampling import (
    default_orientation,
    random_orientation,
    random_yaw_orientation,
    sample_cylinder,
    sample_gaussian,
    sample_log_uniform,
    sample_triangle,
    sample_uniform,
)
from .scalars import copysign, normalize, saturate, scale_transform, unscale_transform, wrap_to_pi
