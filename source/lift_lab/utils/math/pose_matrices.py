"""Poses as homogeneous 4x4 matrices, and interpolation between poses."""

from __future__ import annotations

import math

import torch

from .rotations import (
    axis_angle_from_quat,
    matrix_from_euler,
    matrix_from_quat,
    quat_from_angle_axis,
    quat_from_matrix,
)


def make_pose(pos: torch.Tensor, rot: torch.Tensor) -> torch.Tensor:
    """Pose matrices of positions (..., 3) and rotation matrices (..., 3, 3). Shape is (..., 4, 4)."""
    pose = torch.zeros(*pos.shape[:-1], 4, 4, dtype=pos.dtype, device=pos.device)
    pose[..., :3, :3] = rot
    pose[..., :3, 3] = pos
    pose[..., 3, 3] = 1.0
    return pose


def unmake_pose(pose: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """Positions (..., 3) and rotation matrices (..., 3, 3) of pose matrices (..., 4, 4); views."""
    return pose[..., :3, 3], pose[..., :3, :3]


def pose_inv(pose: torch.Tensor) -> torch.Tensor:
    """Inverse of pose matrices. Shape is (..., 4, 4)."""
    pos, rot = unmake_pose(pose)
    inverse_rot = rot.transpose(-1, -2)
    return make_pose(-(inverse_rot @ pos.unsqueeze(-1)).squeeze(-1), inverse_rot)


def pose_in_A_to_pose_in_B(pose_in_A: torch.Tensor, pose_A_in_B: torch.Tensor) -> torch.Tensor:
    """Pose matrices of C in B, of those of C in A and of A in B. Shapes are (..., 4, 4)."""
    return pose_A_in_B @ pose_in_A


def transform_poses_from_frame_A_to_frame_B(
    src_poses: torch.Tensor, frame_A: torch.Tensor, frame_B: torch.Tensor
) -> torch.Tensor:
    """Move poses rigidly so that they lie to ``frame_A`` as they lay to ``frame_B``.

    Args:
        src_poses: pose matrices. Shape is (T, 4, 4).
        frame_A: new frame of reference. Shape is (4, 4).
        frame_B: frame of reference of ``src_poses``. Shape is (4, 4).

    Returns:
        Pose matrices ``A B^-1 src``. Shape is (T, 4, 4).
    """
    return frame_A @ pose_inv(frame_B) @ src_poses


##
# Interpolation
##


def quat_slerp(q1: torch.Tensor, q2: torch.Tensor, tau: float | torch.Tensor) -> torch.Tensor:
    """Spherical linear interpolation along the shorter way.

    Args:
        q1: unit quaternions (w, x, y, z) at ``tau = 0``. Shape is (..., 4).
        q2: unit quaternions at ``tau = 1``. Shape is (..., 4).
        tau: where to interpolate. A number, or a tensor that broadcasts against the leading dimensions.

    Returns:
        Unit quaternions. Shape is (..., 4).
    """
    tau = torch.as_tensor(tau, dtype=q1.dtype, device=q1.device).unsqueeze(-1)
    cos = (q1 * q2).sum(dim=-1, keepdim=True)
    q2 = torch.where(cos < 0, -q2, q2)
    angle = torch.acos(cos.abs().clamp(max=1.0))
    sin = torch.sin(angle)
    near = sin < 1e-6  # nearly the same orientation: interpolate linearly
    safe_sin = torch.where(near, 1.0, sin)
    weight1 = torch.where(near, 1.0 - tau, torch.sin((1.0 - tau) * angle) / safe_sin)
    weight2 = torch.where(near, tau, torch.sin(tau * angle) / safe_sin)
    return weight1 * q1 + weight2 * q2


def interpolate_rotations(R1: torch.Tensor, R2: torch.Tensor, num_steps: int, axis_angle: bool = True) -> torch.Tensor:
    """Rotation matrices on the shortest way from one to another.

    Args:
        R1: first rotation. Shape is (3, 3).
        R2: last rotation. Shape is (3, 3).
        num_steps: number of steps from first to last.
        axis_angle: turn about the axis between them; otherwise interpolate quaternions (the same way, computed
            differently).

    Returns:
        Shape is (num_steps + 1, 3, 3), ends included.
    """
    tau = torch.linspace(0.0, 1.0, num_steps + 1, dtype=R1.dtype, device=R1.device)[:-1]
    if axis_angle:
        rotation = axis_angle_from_quat(quat_from_matrix(R2 @ R1.transpose(-1, -2)))
        angle = tau * torch.linalg.vector_norm(rotation)
        steps = matrix_from_quat(quat_from_angle_axis(angle, rotation.expand(num_steps, 3))) @ R1
    else:
        steps = matrix_from_quat(quat_slerp(quat_from_matrix(R1), quat_from_matrix(R2), tau))
    return torch.cat((steps, R2[None]))


def interpolate_poses(
    pose_1: torch.Tensor,
    pose_2: torch.Tensor,
    num_steps: int | None = None,
    step_size: float | None = None,
    perturb: bool = False,
) -> tuple[torch.Tensor, int]:
    """Pose matrices on the straight way from one to another, turning at a constant rate.

    Args:
        pose_1: first pose. Shape is (4, 4).
        pose_2: last pose. Shape is (4, 4).
        num_steps: number of poses between the ends.
        step_size: distance between poses, to derive ``num_steps`` from. Give one of the two.
        perturb: whether the positions in between are moved at random along the way, by up to half a step.

    Returns:
        Poses, ends included, of shape (num_steps + 2, 4, 4), and ``num_steps``.

    Raises:
        ValueError: both or neither of ``num_steps`` and ``step_size`` are given.
    """
    if (num_steps is None) == (step_size is None):
        raise ValueError("interpolate_poses: give one of num_steps and step_size")
    pos_1, rot_1 = unmake_pose(pose_1)
    pos_2, rot_2 = unmake_pose(pose_2)
    if step_size is not None:
        num_steps = math.ceil(float(torch.linalg.vector_norm(pos_2 - pos_1)) / step_size)
    assert num_steps is not None
    intervals = num_steps + 1
    grid = torch.arange(intervals + 1, dtype=pos_1.dtype, device=pos_1.device)
    if perturb:
        grid[1:-1] += torch.rand(num_steps, dtype=grid.dtype, device=grid.device) - 0.5
    positions = torch.lerp(pos_1, pos_2, (grid / intervals).unsqueeze(-1))
    return make_pose(positions, interpolate_rotations(rot_1, rot_2, intervals)), num_steps


##
# Random poses
##


def generate_random_rotation(rot_boundary: float = 2 * math.pi) -> torch.Tensor:
    """Rotation matrix ``Rz Ry Rx`` of three angles that are uniform in [0, rot_boundary). Shape is (3, 3)."""
    return matrix_from_euler(torch.rand(3) * rot_boundary, "ZYX")


def generate_random_translation(pos_boundary: float = 1) -> torch.Tensor:
    """Vector that is uniform in [-pos_boundary, pos_boundary) along each axis. Shape is (3,)."""
    return (2.0 * torch.rand(3) - 1.0) * pos_boundary


def generate_random_transformation_matrix(pos_boundary: float = 1, rot_boundary: float = 2 * math.pi) -> torch.Tensor:
    """Pose matrix of a random rotation and a random translation. Shape is (4, 4)."""
    return make_pose(generate_random_translation(pos_boundary), generate_random_rotation(rot_boundary))
