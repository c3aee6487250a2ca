"""Stage units and rigid poses: everything that turns USD's numbers into SI, radians and a Z-up world."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Gf, Usd, UsdGeom, UsdPhysics

DEG = math.pi / 180.0
AXES = {"X": 0, "Y": 1, "Z": 2}
UNBOUNDED = 1e20
"""Magnitude from which an authored limit counts as infinite (USD authors use inf, 1e30 and FLT_MAX alike)."""


@dataclass(frozen=True)
class Units:
    """Scale of one stage: `length` metres and `mass` kilograms per unit, `up` rotates its world to Z-up."""

    length: float
    mass: float
    up: np.ndarray

    @classmethod
    def of(cls, stage: Usd.Stage) -> Units:
        """Read metersPerUnit, kilogramsPerUnit and upAxis."""
        up = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]) if UsdGeom.GetStageUpAxis(stage) == "Y" else np.eye(3)
        return cls(UsdGeom.GetStageMetersPerUnit(stage), UsdPhysics.GetStageKilogramsPerUnit(stage), up)

    def factor(self, unit: str, angular: bool = False) -> float:
        """SI value of one stage unit of `unit`; `angular` tells a rotational degree of freedom.

        Units: si, length, density, position (deg or length), velocity, effort (force or torque), inertia
        (armature), gain (stiffness and damping: per degree if angular), friction_length, inertia_tensor.
        """
        length, mass = self.length, self.mass
        table = {
            "si": 1.0,
            "mass": mass,
            "length": length,
            "density": mass / length**3,
            "inertia_tensor": mass * length**2,
            "position": DEG if angular else length,
            "velocity": DEG if angular else length,
            "effort": mass * length**2 if angular else mass * length,
            "inertia": mass * length**2 if angular else mass,
            "gain": mass * length**2 / DEG if angular else mass,
            "gain_rad": mass * length**2 if angular else mass,
        }
        return table[unit]


def quat_array(quat: Any) -> np.ndarray:
    """Gf.Quat* or a wxyz sequence as a normalised wxyz array; a zero quaternion becomes the identity."""
    if hasattr(quat, "GetReal"):
        quat = (quat.GetReal(), *quat.GetImaginary())
    values = np.asarray(quat, dtype=float)
    norm = float(np.linalg.norm(values))
    return values / norm if norm > 1e-12 else np.array([1.0, 0, 0, 0])


def quat_to_mat(quat: object) -> np.ndarray:
    """Rotation matrix of a wxyz quaternion."""
    w, x, y, z = quat_array(quat)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def mat_to_quat(mat: np.ndarray) -> np.ndarray:
    """Wxyz quaternion of a rotation matrix, real part not negative."""
    m = np.asarray(mat, dtype=float)
    # Largest of the four squared components first: never divides by a small number.
    squares = 0.25 * (1 + np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) @ np.diag(m))
    i = int(np.argmax(squares))
    pivot = math.sqrt(max(float(squares[i]), 0.0))
    rows = {
        0: (4 * pivot * pivot, m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]),
        1: (m[2, 1] - m[1, 2], 4 * pivot * pivot, m[0, 1] + m[1, 0], m[0, 2] + m[2, 0]),
        2: (m[0, 2] - m[2, 0], m[0, 1] + m[1, 0], 4 * pivot * pivot, m[1, 2] + m[2, 1]),
        3: (m[1, 0] - m[0, 1], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], 4 * pivot * pivot),
    }
    quat = quat_array(np.array(rows[i]) / (4 * pivot))
    return -quat if quat[0] < 0 else quat


def axis_rotation(axis: str) -> np.ndarray:
    """Rotation that turns the local Z axis onto the USD axis token X, Y or Z."""
    half = math.sqrt(0.5)
    quats = {"X": (half, 0, half, 0), "Y": (half, -half, 0, 0), "Z": (1, 0, 0, 0)}
    return np.round(quat_to_mat(quats[axis]))


@dataclass(frozen=True)
class Pose:
    """A rigid frame: `pos` in metres and rotation matrix `rot`."""

    pos: np.ndarray
    rot: np.ndarray

    @classmethod
    def identity(cls) -> Pose:
        return cls(np.zeros(3), np.eye(3))

    @classmethod
    def of(cls, pos: object, quat: object, length: float = 1.0) -> Pose:
        """Pose from a position in units of `length` and a quaternion."""
        return cls(np.asarray(pos, dtype=float) * length, quat_to_mat(quat))

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(self.pos + self.rot @ other.pos, self.rot @ other.rot)

    def inverse(self) -> Pose:
        return Pose(-self.rot.T @ self.pos, self.rot.T)

    @property
    def quat(self) -> np.ndarray:
        """Orientation as wxyz, without the rounding noise of the last digits."""
        return np.round(mat_to_quat(self.rot), 14) + 0.0

    @property
    def position(self) -> np.ndarray:
        """`pos` without rounding noise below a picometre."""
        return np.round(self.pos, 13) + 0.0


def gf_matrix(matrix: Gf.Matrix4d) -> tuple[np.ndarray, np.ndarray]:
    """Linear part (column vectors) and translation of a Gf matrix, which multiplies row vectors."""
    array = np.array(matrix, dtype=float)
    return array[:3, :3].T, array[3, :3]


def polar(linear: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Split a linear map into rotation and symmetric stretch: linear = rotation @ stretch.

    A reflection goes into the stretch as a whole, as Gf.Matrix4d.Factor does, so that the rotation is proper.
    """
    u, s, vt = np.linalg.svd(linear)
    rotation = u @ vt
    stretch = (vt.T * s) @ vt
    if np.linalg.det(rotation) < 0:
        rotation, stretch = -rotation, -stretch
    return rotation, stretch
