"""Poses as a position and a unit quaternion (w, x, y, z): composing, subtracting, comparing.

``t01, q01`` is the pose of frame 1 in frame 0.
"""

from __future__ import annotations

from typing import Literal

import torch

from .rotations import (
    axis_angle_from_quat,
    quat_apply,
    quat_apply_inverse,
    quat_inv,
    quat_mul,
)


def is_identity_pose(pos: torch.Tensor, rot: torch.Tensor) -> bool:
    """Whether all poses are the identity, to the tolerance of :func:`torch.allclose`. Shapes are (N, 3), (N, 4)."""
    identity = torch.zeros_like(rot)
    identity[..., 0] = 1.0
    return torch.allclose(pos, torch.zeros_like(pos)) and torch.allclose(rot, identity)


def combine_frame_transforms(
    t01: torch.Tensor, q01: torch.Tensor, t12: torch.Tensor | None = None, q12: torch.Tensor | None = None
) -> tuple[torch.Tensor, torch.Tensor]:
    """Pose of frame 2 in frame 0: ``T02 = T01 T12``.

    Args:
        t01: Position of frame 1 in frame 0. Shape is (N, 3).
        q01: Orientation of frame 1 in frame 0. Shape is (N, 4).
        t12: Position of frame 2 in frame 1. Shape is (N, 3). None means zero.
        q12: Orientation of frame 2 in frame 1. Shape is (N, 4). None means the identity.

    Returns:
        Position and orientation of frame 2 in frame 0. Shapes are (N, 3) and (N, 4).
    """
    t02 = t01 if t12 is None else t01 + quat_apply(q01, t12)
    q02 = q01 if q12 is None else quat_mul(q01, q12)
    return t02, q02


def subtract_frame_transforms(
    t01: torch.Tensor, q01: torch.Tensor, t02: torch.Tensor | None = None, q02: torch.Tensor | None = None
) -> tuple[torch.Tensor, torch.Tensor]:
    """Pose of frame 2 in frame 1: ``T12 = T01^-1 T02``.

    Args:
        t01: Position of frame 1 in frame 0. Shape is (N, 3).
        q01: Orientation of frame 1 in frame 0. Shape is (N, 4).
        t02: Position of frame 2 in frame 0. Shape is (N, 3). None means zero.
        q02: Orientation of frame 2 in frame 0. Shape is (N, 4). None means the identity.

    Returns:
        Position and orientation of frame 2 in frame 1. Shapes are (N, 3) and (N, 4).
    """
    q10 = quat_inv(q01)
    t12 = quat_apply(q10, -t01 if t02 is None else t02 - t01)
    q12 = q10 if q02 is None else quat_mul(q10, q02)
    return t12, q12


def rigid_body_twist_transform(
    v0: torch.Tensor, w0: torch.Tensor, t01: torch.Tensor, q01: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor]:
    """Velocity of a rigid body at, and expressed in, another frame that is fixed to it.

    Args:
        v0: Linear velocity of the body at the origin of frame 0, in frame 0. Shape is (N, 3).
        w0: Angular velocity of the body, in frame 0. Shape is (N, 3).
        t01: Position of frame 1 in frame 0. Shape is (N, 3).
        q01: Orientation of frame 1 in frame 0. Shape is (N, 4).

    Returns:
        Linear velocity at the origin of frame 1 and angular velocity, both in frame 1. Shapes are (N, 3).
    """
    v1 = quat_apply_inverse(q01, v0 + torch.linalg.cross(w0, t01))
    return v1, quat_apply_inverse(q01, w0)


def compute_pose_error(
    t01: torch.Tensor,
    q01: torch.Tensor,
    t02: torch.Tensor,
    q02: torch.Tensor,
    rot_error_type: Literal["quat", "axis_angle"] = "axis_angle",
) -> tuple[torch.Tensor, torch.Tensor]:
    """Error from a source pose (1) to a target pose (2), in frame 0.

    Args:
        t01: Position of the source. Shape is (N, 3).
        q01: Orientation of the source. Shape is (N, 4).
        t02: Position of the target. Shape is (N, 3).
        q02: Orientation of the target. Shape is (N, 4).
        rot_error_type: form of the orientation error: "quat" (N, 4), or "axis_angle" (N, 3) in rad.

    Returns:
        Position error (N, 3) and orientation error.

    Raises:
        ValueError: another ``rot_error_type``.
    """
    if rot_error_type not in ("quat", "axis_angle"):
        raise ValueError(f"compute_pose_error: rot_error_type is 'quat' or 'axis_angle', not {rot_error_type!r}")
    quat_error = quat_mul(q02, quat_inv(q01))
    return t02 - t01, quat_error if rot_error_type == "quat" else axis_angle_from_quat(quat_error)


def apply_delta_pose(
    source_pos: torch.Tensor, source_rot: torch.Tensor, delta_pose: torch.Tensor, eps: float = 1.0e-6
) -> tuple[torch.Tensor, torch.Tensor]:
    """Displace a pose by a translation and a rotation, both in the frame that the pose is given in.

    Args:
        source_pos: Shape is (N, 3).
        source_rot: Shape is (N, 4).
        delta_pose: translation, then axis-angle vector in rad. Shape is (N, 6).
        eps: angle in rad up to which the orientation does not change.

    Returns:
        Displaced position (N, 3) and orientation (N, 4).
    """
    rotation = delta_pose[:, 3:6]
    half_angle = 0.5 * torch.linalg.vector_norm(rotation, dim=-1, keepdim=True)
    delta_rot = torch.cat((half_angle.cos(), 0.5 * rotation * torch.sinc(half_angle / torch.pi)), dim=-1)
    target_rot = torch.where(half_angle > 0.5 * eps, quat_mul(delta_rot, source_rot), source_rot)
    return source_pos + delta_pose[:, :3], target_rot


def transform_points(
    points: torch.Tensor, pos: torch.Tensor | None = None, quat: torch.Tensor | None = None
) -> torch.Tensor:
    """Rotate and then translate points: ``R(quat) p + pos``.

    Args:
        points: Shape is (N, P, 3) or (P, 3).
        pos: Shape is (N, 3) or (3,). None means zero.
        quat: Shape is (N, 4) or (4,). None means the identity.

    Returns:
        Transformed points, a new tensor. Shape is (N, P, 3), or (P, 3) where nothing is batched.

    Raises:
        ValueError: other shapes.
    """
    if points.dim() not in (2, 3):
        raise ValueError(f"transform_points: expected points of shape (N, P, 3) or (P, 3), got {tuple(points.shape)}")
    for name, value in (("pos", pos), ("quat", quat)):
        if value is not None and value.dim() not in (1, 2):
            raise ValueError(f"transform_points: expected {name} of shape (N, D) or (D,), got {tuple(value.shape)}")
    moved = points
    if quat is not None:
        moved = quat_apply(quat.unsqueeze(-2), moved)
    if pos is not None:
        moved = moved + pos.unsqueeze(-2)
    return moved.clone() if moved is points else moved
