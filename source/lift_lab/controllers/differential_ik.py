"""Differential inverse kinematics: joint positions that move an end effector towards a pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.math import apply_delta_pose, compute_pose_error

if TYPE_CHECKING:
    from .differential_ik_cfg import DifferentialIKControllerCfg


class DifferentialIKController:
    r"""One step of inverse kinematics, :math:`q_{des} = q + J^{\dagger} (x_{des} - x)`, for all environments.

    Poses, Jacobian and commands are in one frame of the caller's choice. Methods and their parameters are those of
    Isaac Lab's controller of this name. See S. R. Buss, "Introduction to Inverse Kinematics with Jacobian Transpose,
    Pseudoinverse and Damped Least Squares methods" (2004).
    """

    def __init__(self, cfg: DifferentialIKControllerCfg, num_envs: int, device: str):
        """Make the buffers.

        Args:
            cfg: the config.
            num_envs: number of environments.
            device: torch device.
        """
        self.cfg = cfg
        self.num_envs = num_envs
        self._device = device
        self.ee_pos_des = torch.zeros(num_envs, 3, device=device)
        """Desired position in m, shape (num_envs, 3)."""
        self.ee_quat_des = torch.zeros(num_envs, 4, device=device)
        """Desired orientation (w, x, y, z), shape (num_envs, 4)."""
        self.ee_quat_des[:, 0] = 1.0

    @property
    def action_dim(self) -> int:
        """Size of a command: 3 for a position, 6 for a change of pose, 7 for a pose."""
        if self.cfg.command_type == "position":
            return 3
        return 6 if self.cfg.use_relative_mode else 7

    def reset(self, env_ids: torch.Tensor | None = None) -> None:
        """Isaac Lab's hook; the controller keeps nothing from one command to the next."""

    def set_command(
        self, command: torch.Tensor, ee_pos: torch.Tensor | None = None, ee_quat: torch.Tensor | None = None
    ) -> None:
        """Set the target of the end effector.

        Args:
            command: position (m), change of pose (m, axis-angle in rad) or pose (m, wxyz), shape
                (num_envs, :attr:`action_dim`).
            ee_pos: current position, shape (num_envs, 3); needed in relative mode.
            ee_quat: current orientation, shape (num_envs, 4); needed for positions and in relative mode.

        Raises:
            ConfigError: the current pose is needed and was not given.
        """
        relative = self.cfg.use_relative_mode
        if self.cfg.command_type == "position":
            self.ee_pos_des = _needed(ee_pos, "position") + command if relative else command.clone()
            self.ee_quat_des = _needed(ee_quat, "orientation").clone()
        elif relative:
            self.ee_pos_des, self.ee_quat_des = apply_delta_pose(
                _needed(ee_pos, "position"), _needed(ee_quat, "orientation"), command
            )
        else:
            self.ee_pos_des = command[:, :3].clone()
            self.ee_quat_des = torch.nn.functional.normalize(command[:, 3:7], dim=-1)

    def compute(
        self, ee_pos: torch.Tensor, ee_quat: torch.Tensor, jacobian: torch.Tensor, joint_pos: torch.Tensor
    ) -> torch.Tensor:
        """Compute joint positions that bring the end effector nearer to its target.

        Args:
            ee_pos: current position, shape (num_envs, 3).
            ee_quat: current orientation, shape (num_envs, 4).
            jacobian: rows linear then angular, shape (num_envs, 6, num_joints).
            joint_pos: current joint positions, shape (num_envs, num_joints).

        Returns:
            Joint positions, shape (num_envs, num_joints).
        """
        if self.cfg.command_type == "position":
            return joint_pos + self._joint_step(self.ee_pos_des - ee_pos, jacobian[:, :3])
        error = compute_pose_error(ee_pos, ee_quat, self.ee_pos_des, self.ee_quat_des, rot_error_type="axis_angle")
        return joint_pos + self._joint_step(torch.cat(error, dim=-1), jacobian)

    def _joint_step(self, error: torch.Tensor, jacobian: torch.Tensor) -> torch.Tensor:
        """Change of the joints for an error of shape (num_envs, m), m rows of the Jacobian."""
        params = self.cfg.ik_params or {}
        error = error.unsqueeze(-1)
        transposed = jacobian.transpose(1, 2)
        if self.cfg.ik_method == "pinv":
            step = params["k_val"] * torch.linalg.pinv(jacobian) @ error
        elif self.cfg.ik_method == "svd":
            u, s, vh = torch.linalg.svd(jacobian, full_matrices=False)
            inverse = torch.where(s > params["min_singular_value"], 1.0 / s, torch.zeros_like(s))
            step = params["k_val"] * vh.mT @ (inverse.unsqueeze(-1) * (u.mT @ error))
        elif self.cfg.ik_method == "trans":
            step = params["k_val"] * transposed @ error
        else:
            damping = params["lambda_val"] ** 2 * torch.eye(jacobian.shape[1], device=self._device)
            step = transposed @ torch.linalg.solve(jacobian @ transposed + damping, error)
        return step.squeeze(-1)


def _needed(value: torch.Tensor | None, what: str) -> torch.Tensor:
    if value is None:
        raise ConfigError(f"this command needs the current end-effector {what}")
    return value
