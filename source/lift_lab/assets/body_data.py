"""State of an asset's bodies under all of Isaac Lab's names."""

from __future__ import annotations

import torch

from .body_state import BodyState


class BodyData(BodyState):
    """Poses and velocities of an asset's root and bodies; :class:`BodyState` computes them."""

    @property
    def root_pos_w(self) -> torch.Tensor:
        """Root position in m, shape (num_envs, 3)."""
        return self.root_link_pos_w

    @property
    def root_quat_w(self) -> torch.Tensor:
        """Root orientation (w, x, y, z), shape (num_envs, 4)."""
        return self.root_link_quat_w

    @property
    def root_pose_w(self) -> torch.Tensor:
        """Root position and orientation, shape (num_envs, 7)."""
        return self.root_link_pose_w

    @property
    def root_vel_w(self) -> torch.Tensor:
        """Velocity of the root's centre of mass, linear (m/s) then angular (rad/s), shape (num_envs, 6)."""
        return self.root_com_vel_w

    @property
    def root_lin_vel_w(self) -> torch.Tensor:
        """Linear velocity of the root's centre of mass in m/s, shape (num_envs, 3)."""
        return self.root_com_vel_w[..., 0:3]

    @property
    def root_ang_vel_w(self) -> torch.Tensor:
        """Angular velocity of the root's centre of mass in rad/s, shape (num_envs, 3)."""
        return self.root_com_vel_w[..., 3:6]

    @property
    def root_com_lin_vel_w(self) -> torch.Tensor:
        """Linear velocity of the root's centre of mass in m/s, shape (num_envs, 3)."""
        return self.root_com_vel_w[..., 0:3]

    @property
    def root_com_ang_vel_w(self) -> torch.Tensor:
        """Angular velocity of the root's centre of mass in rad/s, shape (num_envs, 3)."""
        return self.root_com_vel_w[..., 3:6]

    @property
    def root_com_pos_w(self) -> torch.Tensor:
        """Position of the root's centre of mass in m, shape (num_envs, 3)."""
        return self.root_com_pose_w[..., 0:3]

    @property
    def root_com_quat_w(self) -> torch.Tensor:
        """Orientation of the root's principal axes of inertia (w, x, y, z), shape (num_envs, 4)."""
        return self.root_com_pose_w[..., 3:7]

    @property
    def root_link_lin_vel_w(self) -> torch.Tensor:
        """Linear velocity of the root's origin in m/s, shape (num_envs, 3)."""
        return self.root_link_vel_w[..., 0:3]

    @property
    def root_link_ang_vel_w(self) -> torch.Tensor:
        """Angular velocity of the root's origin in rad/s, shape (num_envs, 3)."""
        return self.root_link_vel_w[..., 3:6]

    @property
    def root_com_lin_vel_b(self) -> torch.Tensor:
        """Linear velocity of the root's centre of mass in its link frame, shape (num_envs, 3)."""
        return self.root_lin_vel_b

    @property
    def root_com_ang_vel_b(self) -> torch.Tensor:
        """Angular velocity of the root in its link frame, shape (num_envs, 3)."""
        return self.root_ang_vel_b

    @property
    def root_link_ang_vel_b(self) -> torch.Tensor:
        """Angular velocity of the root in its link frame, shape (num_envs, 3)."""
        return self.root_ang_vel_b

    @property
    def body_pos_w(self) -> torch.Tensor:
        """Positions of the bodies in m, shape (num_envs, num_bodies, 3)."""
        return self.body_link_pos_w

    @property
    def body_quat_w(self) -> torch.Tensor:
        """Orientations of the bodies (w, x, y, z), shape (num_envs, num_bodies, 4)."""
        return self.body_link_quat_w

    @property
    def body_pose_w(self) -> torch.Tensor:
        """Positions and orientations of the bodies, shape (num_envs, num_bodies, 7)."""
        return self.body_link_pose_w

    @property
    def body_vel_w(self) -> torch.Tensor:
        """Velocities of the bodies' centres of mass, shape (num_envs, num_bodies, 6)."""
        return self.body_com_vel_w

    @property
    def body_lin_vel_w(self) -> torch.Tensor:
        """Linear velocities of the bodies' centres of mass in m/s, shape (num_envs, num_bodies, 3)."""
        return self.body_com_vel_w[..., 0:3]

    @property
    def body_ang_vel_w(self) -> torch.Tensor:
        """Angular velocities of the bodies' centres of mass in rad/s, shape (num_envs, num_bodies, 3)."""
        return self.body_com_vel_w[..., 3:6]

    @property
    def body_com_lin_vel_w(self) -> torch.Tensor:
        """Linear velocities of the bodies' centres of mass in m/s, shape (num_envs, num_bodies, 3)."""
        return self.body_com_vel_w[..., 0:3]

    @property
    def body_com_ang_vel_w(self) -> torch.Tensor:
        """Angular velocities of the bodies' centres of mass in rad/s, shape (num_envs, num_bodies, 3)."""
        return self.body_com_vel_w[..., 3:6]

    @property
    def body_link_lin_vel_w(self) -> torch.Tensor:
        """Linear velocities of the bodies' origins in m/s, shape (num_envs, num_bodies, 3)."""
        return self.body_link_vel_w[..., 0:3]

    @property
    def body_link_ang_vel_w(self) -> torch.Tensor:
        """Angular velocities of the bodies' origins in rad/s, shape (num_envs, num_bodies, 3)."""
        return self.body_link_vel_w[..., 3:6]

    @property
    def body_acc_w(self) -> torch.Tensor:
        """Accelerations of the bodies' centres of mass without gravity's, shape (num_envs, num_bodies, 6)."""
        return self.body_com_acc_w

    @property
    def body_lin_acc_w(self) -> torch.Tensor:
        """Linear accelerations of the bodies' centres of mass in m/s^2, shape (num_envs, num_bodies, 3)."""
        return self.body_com_acc_w[..., 0:3]

    @property
    def body_ang_acc_w(self) -> torch.Tensor:
        """Angular accelerations of the bodies' centres of mass in rad/s^2, shape (num_envs, num_bodies, 3)."""
        return self.body_com_acc_w[..., 3:6]

    @property
    def body_com_lin_acc_w(self) -> torch.Tensor:
        """Linear accelerations of the bodies' centres of mass in m/s^2, shape (num_envs, num_bodies, 3)."""
        return self.body_com_acc_w[..., 0:3]

    @property
    def body_com_ang_acc_w(self) -> torch.Tensor:
        """Angular accelerations of the bodies' centres of mass in rad/s^2, shape (num_envs, num_bodies, 3)."""
        return self.body_com_acc_w[..., 3:6]

    @property
    def com_pos_b(self) -> torch.Tensor:
        """Centres of mass in the link frames, shape (num_envs, num_bodies, 3)."""
        return self.body_com_pos_b

    @property
    def com_quat_b(self) -> torch.Tensor:
        """Principal axes in the link frames (w, x, y, z), shape (num_envs, num_bodies, 4)."""
        return self.body_com_quat_b
