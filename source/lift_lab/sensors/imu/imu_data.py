"""Readings of an inertial measurement unit."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import torch

from lift_lab.utils import math as math_utils
from lift_lab.utils.attributes import EntityData

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics


class ImuData(EntityData):
    """Readings, in the sensor's frame (`_b`), with Isaac Lab's names.

    Pose and velocities belong to the current state. Accelerations belong to the last physics step, in the sensor's
    frame at its start.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_columns", "_dt", "_origins_w", "_sensordata", "_site"})

    def __init__(
        self,
        physics: Physics,
        origins_w: torch.Tensor,
        site: int,
        columns: dict[str, int],
        bias_w: tuple[float, float, float],
    ):
        self._physics = physics
        self._origins_w = origins_w
        self._site = site
        self._columns = columns
        self._sensordata = physics.field("sensordata")
        shape = (physics.num_envs, 3)
        self._bias_w = torch.tensor(bias_w, dtype=torch.float32, device=physics.device).expand(shape)
        self._gravity_w = physics.gravity
        self._dt = physics.model.opt.timestep
        self.stepped = torch.zeros(physics.num_envs, 1, dtype=torch.bool, device=physics.device)
        """Whether the engine has stepped since each environment was reset, shape (num_envs, 1)."""

    def _read(self, name: str) -> torch.Tensor:
        start = self._columns[name]
        return self._sensordata[:, start : start + 3]

    def _into_b(self, vector_w: torch.Tensor) -> torch.Tensor:
        return math_utils.quat_apply_inverse(self.quat_w, vector_w)

    def _into_b_before(self, vector_w: torch.Tensor) -> torch.Tensor:
        """Into the frame as it was before the last physics step, in which it turned at the present rate."""
        turn = self._read("gyro") * self._dt
        turned = math_utils.quat_from_angle_axis(torch.linalg.vector_norm(turn, dim=-1), turn)
        return math_utils.quat_apply(turned, self._into_b(vector_w))

    @property
    def pos_w(self) -> torch.Tensor:
        """Position of the sensor in m, shape (num_envs, 3)."""
        return self._physics.current("site_xpos")[:, self._site] + self._origins_w

    @property
    def quat_w(self) -> torch.Tensor:
        """Orientation of the sensor (w, x, y, z), shape (num_envs, 4)."""
        mat = self._physics.current("site_xmat")[:, self._site]
        return math_utils.quat_from_matrix(mat.reshape(-1, 3, 3))

    @property
    def projected_gravity_b(self) -> torch.Tensor:
        """Direction of gravity at start, shape (num_envs, 3); zero where there is none."""
        return self._into_b(torch.nn.functional.normalize(self._gravity_w, dim=-1))

    @property
    def lin_vel_b(self) -> torch.Tensor:
        """Velocity of the sensor in m/s, shape (num_envs, 3)."""
        return self._read("velocimeter").clone()

    @property
    def ang_vel_b(self) -> torch.Tensor:
        """Angular velocity in rad/s, shape (num_envs, 3)."""
        return self._read("gyro").clone()

    @property
    def lin_acc_b(self) -> torch.Tensor:
        """Acceleration plus the config's bias in m/s^2, shape (num_envs, 3). After a reset the bias alone."""
        # the engine's reading is the acceleration minus gravity
        measured = self._read("accelerometer") + self._into_b_before(self._physics.gravity + self._bias_w)
        return torch.where(self.stepped, measured, self._into_b(self._bias_w))

    @property
    def ang_acc_b(self) -> torch.Tensor:
        """Angular acceleration in rad/s^2, shape (num_envs, 3). After a reset zero."""
        return torch.where(self.stepped, self._into_b_before(self._read("frameangacc")), 0.0)
