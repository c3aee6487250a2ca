"""Kinematics of an arm's end effector in the arm's root frame, for the task-space actions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import torch

from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.indexing import columns, compact_index

if TYPE_CHECKING:
    from lift_lab.assets import Articulation


class Offset(Protocol):
    """A pose in a body's frame."""

    pos: tuple[float, float, float]
    rot: tuple[float, float, float, float]


class EndEffector:
    """A frame on a body of an articulation, moved by some of its joints.

    Everything is in the root frame (``_b``): relative to the root's position, in its axes.
    """

    def __init__(
        self, asset: Articulation, joint_names: Sequence[str], body_name: str, offset: Offset | None, owner: str
    ):
        """Find joints and body.

        Raises:
            ConfigError: the body name does not match exactly one body.
        """
        self.asset = asset
        joint_ids, self.joint_names = asset.find_joints(joint_names)
        self.joint_ids = compact_index(joint_ids, asset.num_joints, asset.device)
        bodies, names = asset.find_bodies(body_name)
        if len(bodies) != 1:
            raise ConfigError(f"{owner}: body_name '{body_name}' must match one body, it matches {names}")
        self.body_id = bodies[0]
        self.body_name = names[0]
        self._offset: tuple[torch.Tensor, torch.Tensor] | None = None
        if offset is not None:
            pos = torch.tensor([offset.pos], dtype=torch.float32, device=asset.device)
            rot = torch.tensor([offset.rot], dtype=torch.float32, device=asset.device)
            rot = rot / rot.norm()
            count = asset.num_instances
            self._offset = (pos.repeat(count, 1), rot.repeat(count, 1))

    @property
    def joint_pos(self) -> torch.Tensor:
        """Positions of the joints, shape (num_envs, num_joints)."""
        return columns(self.asset.data.joint_pos, self.joint_ids)

    @property
    def joint_vel(self) -> torch.Tensor:
        """Velocities of the joints, shape (num_envs, num_joints)."""
        return columns(self.asset.data.joint_vel, self.joint_ids)

    def pose_b(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Position (m) and orientation (wxyz), shapes (num_envs, 3) and (num_envs, 4)."""
        data = self.asset.data
        pos, quat = math_utils.subtract_frame_transforms(
            data.root_pos_w,
            data.root_quat_w,
            data.body_pos_w[:, self.body_id],
            data.body_quat_w[:, self.body_id],
        )
        if self._offset is None:
            return pos, quat
        return math_utils.combine_frame_transforms(pos, quat, *self._offset)

    def jacobian_b(self) -> torch.Tensor:
        """Motion of the frame for each joint, rows linear then angular, shape (num_envs, 6, num_joints)."""
        jacobian = self.asset.get_jacobians(self.body_id)
        jacobian = jacobian if self.joint_ids == slice(None) else jacobian[:, :, self.joint_ids]
        linear, angular = jacobian[:, :3], jacobian[:, 3:]
        if self._offset is not None:
            arm_w = math_utils.quat_apply(self.asset.data.body_quat_w[:, self.body_id], self._offset[0])
            linear = linear + torch.linalg.cross(angular, arm_w.unsqueeze(-1).expand_as(angular), dim=1)
        to_b = math_utils.matrix_from_quat(self.asset.data.root_quat_w).mT
        return torch.cat((to_b @ linear, to_b @ angular), dim=1)

    def velocity_b(self) -> torch.Tensor:
        """Velocity of the frame relative to the root, linear then angular, shape (num_envs, 6)."""
        data = self.asset.data
        velocity = data.body_link_vel_w[:, self.body_id] - data.root_link_vel_w
        linear, angular = velocity[:, :3], velocity[:, 3:]
        # the root's turning carries the frame along
        carried = torch.linalg.cross(data.root_link_vel_w[:, 3:], data.body_pos_w[:, self.body_id] - data.root_pos_w)
        linear = linear - carried
        if self._offset is not None:
            arm_w = math_utils.quat_apply(data.body_quat_w[:, self.body_id], self._offset[0])
            linear = linear + torch.linalg.cross(angular, arm_w)
        root = data.root_quat_w
        return torch.cat(
            (math_utils.quat_apply_inverse(root, linear), math_utils.quat_apply_inverse(root, angular)), dim=-1
        )
