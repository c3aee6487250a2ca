"""Rotations as unit quaternions (w, x, y, z), matrices, Euler angles and axis-angle vectors."""

from __future__ import annotations

from typing import Literal, overload

import numpy as np
import torch

from .scalars import normalize

##
# Algebra of quaternions
##


def quat_unique(q: torch.Tensor) -> torch.Tensor:
    """The one of ``q`` and ``-q`` whose real part is not negative. Shape is (..., 4)."""
    return torch.where(q[..., :1] < 0, -q, q)


def quat_conjugate(q: torch.Tensor) -> torch.Tensor:
    """Conjugate: the inverse of a unit quaternion. Shape is (..., 4)."""
    return torch.cat((q[..., :1], -q[..., 1:]), dim=-1)


def quat_inv(q: torch.Tensor, eps: float = 1e-9) -> torch.Tensor:
    """Inverse, also of quaternions that are not of unit length. Shape is (..., 4).

    Args:
        q: the quaternions.
        eps: least squared length that is divided by.
    """
    return quat_conjugate(q) / (q * q).sum(dim=-1, keepdim=True).clamp(min=eps)


def quat_mul(q1: torch.Tensor, q2: torch.Tensor) -> torch.Tensor:
    """Hamilton product: the rotation ``q2`` followed by ``q1``. Shapes (..., 4) broadcast."""
    if q1.shape != q2.shape:
        q1, q2 = torch.broadcast_tensors(q1, q2)
    (w1, v1), (w2, v2) = torch.split_with_sizes(q1, (1, 3), -1), torch.split_with_sizes(q2, (1, 3), -1)
    real = w1 * w2 - (v1 * v2).sum(dim=-1, keepdim=True)
    imaginary = torch.addcmul(torch.linalg.cross(v1, v2), w1, v2).addcmul_(w2, v1)
    return torch.cat((real, imaginary), dim=-1)


def quat_apply(quat: torch.Tensor, vec: torch.Tensor) -> torch.Tensor:
    """Rotate vectors by unit quaternions.

    Args:
        quat: Shape is (..., 4).
        vec: Shape is (..., 3).

    Returns:
        Rotated vectors. Shape is (..., 3).
    """
    real, imaginary, vec, twice_cross = _rotation_terms(quat, vec)
    return vec + real * twice_cross + torch.linalg.cross(imaginary, twice_cross)


def quat_apply_inverse(quat: torch.Tensor, vec: torch.Tensor) -> torch.Tensor:
    """Rotate vectors by the inverse of unit quaternions. Shapes are (..., 4) and (..., 3)."""
    real, imaginary, vec, twice_cross = _rotation_terms(quat, vec)
    return vec - real * twice_cross + torch.linalg.cross(imaginary, twice_cross)


def _rotation_terms(
    quat: torch.Tensor, vec: torch.Tensor
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]:
    """Real part, imaginary part and vector, which broadcast, and twice the cross product of the latter two."""
    real, imaginary = torch.split_with_sizes(quat, (1, 3), -1)
    if imaginary.shape != vec.shape:
        imaginary, vec = torch.broadcast_tensors(imaginary, vec)
    cross = torch.linalg.cross(imaginary, vec)
    return real, imaginary, vec, cross + cross


quat_rotate = quat_apply
"""Isaac Lab's former name of :func:`quat_apply`."""

quat_rotate_inverse = quat_apply_inverse
"""Isaac Lab's former name of :func:`quat_apply_inverse`."""


def yaw_quat(quat: torch.Tensor) -> torch.Tensor:
    """The rotation about z that is left when roll and pitch (``R = Rz Ry Rx``) are removed. Shape is (..., 4)."""
    w, x, y, z = quat.unbind(-1)
    half_yaw = 0.5 * torch.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    zero = torch.zeros_like(half_yaw)
    return torch.stack((torch.cos(half_yaw), zero, zero, torch.sin(half_yaw)), dim=-1)


def quat_apply_yaw(quat: torch.Tensor, vec: torch.Tensor) -> torch.Tensor:
    """Rotate vectors by the yaw of quaternions only. Shapes are (..., 4) and (..., 3)."""
    return quat_apply(yaw_quat(quat), vec)


def quat_box_minus(q1: torch.Tensor, q2: torch.Tensor) -> torch.Tensor:
    """Axis-angle vector (rad, in the outer frame) of the rotation that takes ``q2`` to ``q1``: log(q1 q2^-1).

    Shapes are (..., 4) and (..., 3). Source: kindr's box-minus operator.
    """
    return axis_angle_from_quat(quat_mul(q1, quat_conjugate(q2)))


def quat_box_plus(q: torch.Tensor, delta: torch.Tensor, eps: float = 1.0e-6) -> torch.Tensor:
    """Turn ``q`` by the axis-angle vector ``delta`` (rad, in the outer frame): exp(delta) q.

    Args:
        q: Shape is (..., 4).
        delta: Shape is (..., 3).
        eps: length of ``delta`` below which it counts as zero.

    Returns:
        Quaternions with a real part that is not negative. Shape is (..., 4).
    """
    angle = torch.linalg.vector_norm(delta, dim=-1, keepdim=True).clamp(min=eps)
    return quat_unique(quat_mul(quat_from_angle_axis(angle.squeeze(-1), delta / angle), q))


def quat_error_magnitude(q1: torch.Tensor, q2: torch.Tensor) -> torch.Tensor:
    """Angle in rad, in [0, pi], of the rotation between two orientations. Shapes are (..., 4) and (...)."""
    difference = quat_mul(q1, quat_conjugate(q2))
    return 2.0 * torch.atan2(torch.linalg.vector_norm(difference[..., 1:], dim=-1), difference[..., 0].abs())


##
# Conversions
##


@overload
def convert_quat(quat: torch.Tensor, to: Literal["xyzw", "wxyz"] = "xyzw") -> torch.Tensor: ...
@overload
def convert_quat(quat: np.ndarray, to: Literal["xyzw", "wxyz"] = "xyzw") -> np.ndarray: ...
def convert_quat(quat: torch.Tensor | np.ndarray, to: Literal["xyzw", "wxyz"] = "xyzw") -> torch.Tensor | np.ndarray:
    """Reorder quaternions from the other convention ``to`` this one.

    Args:
        quat: torch or numpy, (or a sequence, which becomes a tensor). Shape is (..., 4).
        to: "xyzw" (from wxyz) or "wxyz" (from xyzw).

    Raises:
        ValueError: another convention or another shape.
    """
    if not isinstance(quat, (torch.Tensor, np.ndarray)):
        quat = torch.as_tensor(quat, dtype=torch.float32)
    if quat.shape[-1:] != (4,):
        raise ValueError(f"convert_quat: expected shape (..., 4), got {tuple(quat.shape)}")
    if to not in ("xyzw", "wxyz"):
        raise ValueError(f"convert_quat: 'to' is 'xyzw' or 'wxyz', not {to!r}")
    shift = -1 if to == "xyzw" else 1
    return np.roll(quat, shift, axis=-1) if isinstance(quat, np.ndarray) else quat.roll(shift, dims=-1)


def matrix_from_quat(quaternions: torch.Tensor) -> torch.Tensor:
    """Rotation matrices of quaternions (any length). Shapes are (..., 4) and (..., 3, 3)."""
    w, x, y, z = quaternions.unbind(-1)
    s = 2.0 / (quaternions * quaternions).sum(dim=-1)
    entries = (
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
    )
    return torch.stack(entries, dim=-1).unflatten(-1, (3, 3))


def quat_from_matrix(matrix: torch.Tensor) -> torch.Tensor:
    """Unit quaternions of rotation matrices; the largest component is positive. Shapes are (..., 3, 3), (..., 4).

    Each row of ``4 q q^T`` is the quaternion times one of its components; the row of the largest is the exact one.

    Raises:
        ValueError: another shape.
    """
    if matrix.shape[-2:] != (3, 3):
        raise ValueError(f"quat_from_matrix: expected shape (..., 3, 3), got {tuple(matrix.shape)}")
    m00, m01, m02, m10, m11, m12, m20, m21, m22 = matrix.flatten(-2).unbind(-1)
    xw, yw, zw = m21 - m12, m02 - m20, m10 - m01
    xy, xz, yz = m10 + m01, m02 + m20, m12 + m21
    squares = torch.stack(
        (1.0 + m00 + m11 + m22, 1.0 + m00 - m11 - m22, 1.0 - m00 + m11 - m22, 1.0 - m00 - m11 + m22), dim=-1
    )
    ww, xx, yy, zz = squares.unbind(-1)
    outer = torch.stack((ww, xw, yw, zw, xw, xx, xy, xz, yw, xy, yy, yz, zw, xz, yz, zz), dim=-1).unflatten(-1, (4, 4))
    largest = squares.argmax(dim=-1)[..., None, None].expand(*squares.shape[:-1], 1, 4)
    return torch.nn.functional.normalize(outer.gather(-2, largest).squeeze(-2), dim=-1)


def matrix_from_euler(euler_angles: torch.Tensor, convention: str) -> torch.Tensor:
    """Rotation matrices of intrinsic Euler angles.

    Args:
        euler_angles: angles in rad. Shape is (..., 3).
        convention: three axes, e.g. "XYZ" for ``Rx(a0) Ry(a1) Rz(a2)``; neighbours differ.

    Returns:
        Shape is (..., 3, 3).

    Raises:
        ValueError: another shape or convention.
    """
    if euler_angles.dim() == 0 or euler_angles.shape[-1] != 3:
        raise ValueError(f"matrix_from_euler: expected shape (..., 3), got {tuple(euler_angles.shape)}")
    if len(convention) != 3 or set(convention) - set("XYZ") or convention[1] in (convention[0], convention[2]):
        raise ValueError(f"matrix_from_euler: {convention!r} is not three axes of X, Y, Z with neighbours that differ")
    first, second, third = (
        _axis_rotation(axis, angle) for axis, angle in zip(convention, euler_angles.unbind(-1), strict=True)
    )
    return first @ second @ third


def _axis_rotation(axis: str, angle: torch.Tensor) -> torch.Tensor:
    cos, sin, one, zero = angle.cos(), angle.sin(), torch.ones_like(angle), torch.zeros_like(angle)
    entries = {
        "X": (one, zero, zero, zero, cos, -sin, zero, sin, cos),
        "Y": (cos, zero, sin, zero, one, zero, -sin, zero, cos),
        "Z": (cos, -sin, zero, sin, cos, zero, zero, zero, one),
    }[axis]
    return torch.stack(entries, dim=-1).unflatten(-1, (3, 3))


def quat_from_euler_xyz(roll: torch.Tensor, pitch: torch.Tensor, yaw: torch.Tensor) -> torch.Tensor:
    """Quaternions of roll, pitch and yaw in rad, about the fixed x, y and z axes in turn (``R = Rz Ry Rx``).

    Shapes are (...) and (..., 4).
    """
    cr, sr = torch.cos(0.5 * roll), torch.sin(0.5 * roll)
    cp, sp = torch.cos(0.5 * pitch), torch.sin(0.5 * pitch)
    cy, sy = torch.cos(0.5 * yaw), torch.sin(0.5 * yaw)
    cr_cp, sr_sp, sr_cp, cr_sp = cr * cp, sr * sp, sr * cp, cr * sp
    return torch.stack(
        (
            cr_cp * cy + sr_sp * sy,
            sr_cp * cy - cr_sp * sy,
            cr_sp * cy + sr_cp * sy,
            cr_cp * sy - sr_sp * cy,
        ),
        dim=-1,
    )


def euler_xyz_from_quat(
    quat: torch.Tensor, wrap_to_2pi: bool = False
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Roll, pitch and yaw in rad (``R = Rz Ry Rx``) of unit quaternions.

    Args:
        quat: Shape is (..., 4).
        wrap_to_2pi: whether angles are in [0, 2 pi) rather than in (-pi, pi].

    Returns:
        Roll, pitch, yaw. Shape of each is (...).
    """
    w, x, y, z = quat.unbind(-1)
    roll = torch.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = torch.asin((2.0 * (w * y - z * x)).clamp(-1.0, 1.0))
    yaw = torch.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    if wrap_to_2pi:
        return roll % (2 * torch.pi), pitch % (2 * torch.pi), yaw % (2 * torch.pi)
    return roll, pitch, yaw


def axis_angle_from_quat(quat: torch.Tensor, eps: float = 1.0e-6) -> torch.Tensor:
    """Axis-angle vectors of unit quaternions: direction of the axis, length the angle in rad, in [0, pi].

    Args:
        quat: Shape is (..., 4).
        eps: angle below which the series of ``sin`` is used.

    Returns:
        Shape is (..., 3).
    """
    quat = quat_unique(quat)
    imaginary = quat[..., 1:]
    half_angle = torch.atan2(torch.linalg.vector_norm(imaginary, dim=-1, keepdim=True), quat[..., :1])
    angle = 2.0 * half_angle
    small = angle < eps
    sin_half_per_angle = torch.where(
        small, 0.5 - angle * angle / 48.0, torch.sin(half_angle) / torch.where(small, 1.0, angle)
    )
    return imaginary / sin_half_per_angle


def quat_from_angle_axis(angle: torch.Tensor, axis: torch.Tensor) -> torch.Tensor:
    """Unit quaternions of rotations about an axis.

    Args:
        angle: angle in rad. Shape is (...).
        axis: axis of any length. Shape is (..., 3).

    Returns:
        Shape is (..., 4).
    """
    half = 0.5 * angle.unsqueeze(-1)
    imaginary = normalize(axis) * half.sin()
    return normalize(torch.cat((half.cos().expand(*imaginary.shape[:-1], 1), imaginary), dim=-1))


def skew_symmetric_matrix(vec: torch.Tensor) -> torch.Tensor:
    """Matrices ``S`` with ``S b = vec x b``. Shapes are (N, 3) and (N, 3, 3); (3,) gives (1, 3, 3).

    Raises:
        ValueError: another shape.
    """
    if vec.shape[-1:] != (3,):
        raise ValueError(f"skew_symmetric_matrix: expected shape (..., 3), got {tuple(vec.shape)}")
    x, y, z = (vec.unsqueeze(0) if vec.ndim == 1 else vec).unbind(-1)
    zero = torch.zeros_like(x)
    return torch.stack((zero, -z, y, z, zero, -x, -y, x, zero), dim=-1).unflatten(-1, (3, 3))
