"""Operational-space control: joint efforts that make an end effector behave like a mass on springs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.math import (
    apply_delta_pose,
    combine_frame_transforms,
    compute_pose_error,
    matrix_from_quat,
    subtract_frame_transforms,
)

if TYPE_CHECKING:
    from .operational_space_cfg import OperationalSpaceControllerCfg

_TARGET_SIZES = {"pose_abs": 7, "pose_rel": 6, "wrench_abs": 6}
_GAIN_SIZES = {"fixed": 0, "variable_kp": 6, "variable": 12}


class OperationalSpaceController:
    """Motion and contact-wrench control in a task frame, for all environments.

    Arguments and results are in the arm's root frame (``_b``). Commands are in the task frame (``_task``), which is the
    root frame unless one is given. Six-vectors are linear, then angular. Follows O. Khatib, "A unified approach for
    motion and force control of robot manipulators: The operational space formulation" (1987).
    """

    def __init__(self, cfg: OperationalSpaceControllerCfg, num_envs: int, device: str):
        """Check the config and make the buffers.

        Args:
            cfg: the config.
            num_envs: number of environments.
            device: torch device.

        Raises:
            ConfigError: an unknown target type, impedance mode or null-space control.
        """
        self.cfg = cfg
        self.num_envs = num_envs
        self._device = device
        for value, choices, field in (
            *((target, _TARGET_SIZES, "target_types") for target in cfg.target_types),
            (cfg.impedance_mode, _GAIN_SIZES, "impedance_mode"),
            (cfg.nullspace_control, ("none", "position"), "nullspace_control"),
        ):
            if value not in choices:
                raise ConfigError(f"{field}: unknown '{value}': {suggest(value, choices)}")
        self.target_list = [_TARGET_SIZES[target] for target in cfg.target_types]
        """Size of each target in a command."""
        self.target_dim = sum(self.target_list)
        """Size of all targets in a command."""
        self._motion_axes = self._six(cfg.motion_control_axes_task)
        self._wrench_axes = self._six(cfg.contact_wrench_control_axes_task)
        self._set_gains(self._six(cfg.motion_stiffness_task), self._six(cfg.motion_damping_ratio_task))
        self._wrench_gain: torch.Tensor | None = None
        if cfg.contact_wrench_stiffness_task is not None:
            self._wrench_gain = self._six(cfg.contact_wrench_stiffness_task) * self._wrench_axes
        self.reset()

    def _six(self, value: float | Sequence[float]) -> torch.Tensor:
        """One number for all axes, or six, as a tensor of shape (1, 6)."""
        return torch.as_tensor(value, dtype=torch.float32, device=self._device).expand(6)[None]

    def _set_gains(self, stiffness: torch.Tensor, damping_ratio: torch.Tensor) -> None:
        self._stiffness = stiffness * self._motion_axes
        self._damping = 2.0 * self._stiffness.sqrt() * damping_ratio

    @property
    def action_dim(self) -> int:
        """Size of a command: its targets, then stiffness and damping ratio if they are commanded."""
        return self.target_dim + _GAIN_SIZES[self.cfg.impedance_mode]

    def reset(self) -> None:
        """Forget the command."""
        self.desired_ee_pose_b: torch.Tensor | None = None
        """Desired pose, shape (num_envs, 7), or None."""
        self.desired_ee_wrench_b: torch.Tensor | None = None
        """Desired contact wrench, shape (num_envs, 6), or None."""
        self._rot_task_to_b = torch.eye(3, device=self._device).expand(self.num_envs, 3, 3)

    def set_command(
        self,
        command: torch.Tensor,
        current_ee_pose_b: torch.Tensor | None = None,
        current_task_frame_pose_b: torch.Tensor | None = None,
    ) -> None:
        """Set targets and, in the variable modes, gains.

        Args:
            command: the targets in the order of the config's ``target_types``, then stiffness (6) and damping ratio (6)
                as the impedance mode has it. Poses are m and wxyz, changes of pose m and axis-angle in rad, wrenches N
                and N m. Shape (num_envs, :attr:`action_dim`).
            current_ee_pose_b: current pose, shape (num_envs, 7); needed for ``pose_rel``.
            current_task_frame_pose_b: pose of the task frame, shape (num_envs, 7); None is the root frame.

        Raises:
            ConfigError: a command of the wrong shape, or a relative one without the current pose.
        """
        if command.shape != (self.num_envs, self.action_dim):
            raise ConfigError(
                f"a command of shape {tuple(command.shape)} was given; it must be {(self.num_envs, self.action_dim)}"
            )
        targets, gains = command[:, : self.target_dim], command[:, self.target_dim :]
        if self.cfg.impedance_mode != "fixed":
            stiffness = gains[:, :6].clamp(*self.cfg.motion_stiffness_limits_task)
            ratio = self._six(self.cfg.motion_damping_ratio_task)
            if self.cfg.impedance_mode == "variable":
                ratio = gains[:, 6:].clamp(*self.cfg.motion_damping_ratio_limits_task)
            self._set_gains(stiffness, ratio)
        frame = current_task_frame_pose_b
        if frame is None:
            frame = torch.zeros(self.num_envs, 7, device=self._device)
            frame[:, 3] = 1.0
        self._rot_task_to_b = matrix_from_quat(frame[:, 3:])
        parts = torch.split(targets, self.target_list, dim=1)
        for target_type, target in zip(self.cfg.target_types, parts, strict=True):
            if target_type == "wrench_abs":
                self._set_wrench(target, frame)
            else:
                self._set_pose(target_type, target, frame, current_ee_pose_b)

    def _set_pose(
        self, target_type: str, target: torch.Tensor, frame: torch.Tensor, ee_pose_b: torch.Tensor | None
    ) -> None:
        if target_type == "pose_abs":
            pos, quat = target[:, :3], torch.nn.functional.normalize(target[:, 3:], dim=-1)
        else:
            if ee_pose_b is None:
                raise ConfigError("a 'pose_rel' command needs the current end-effector pose")
            pos, quat = subtract_frame_transforms(frame[:, :3], frame[:, 3:], ee_pose_b[:, :3], ee_pose_b[:, 3:])
            pos, quat = apply_delta_pose(pos, quat, target)
        self.desired_ee_pose_b = torch.cat(combine_frame_transforms(frame[:, :3], frame[:, 3:], pos, quat), dim=-1)

    def _set_wrench(self, target: torch.Tensor, frame: torch.Tensor) -> None:
        """A wrench about the task frame's origin, moved to the root's, as Isaac Lab does it.

        The Jacobian is of the end effector, so the moment that the shift adds acts there, too.
        """
        force, torque = self._to_b(target).split(3, dim=-1)
        torque = torque + torch.linalg.cross(frame[:, :3], force)
        self.desired_ee_wrench_b = torch.cat((force, torque), dim=-1)

    def compute(
        self,
        jacobian_b: torch.Tensor,
        current_ee_pose_b: torch.Tensor | None = None,
        current_ee_vel_b: torch.Tensor | None = None,
        current_ee_force_b: torch.Tensor | None = None,
        mass_matrix: torch.Tensor | None = None,
        gravity: torch.Tensor | None = None,
        current_joint_pos: torch.Tensor | None = None,
        current_joint_vel: torch.Tensor | None = None,
        nullspace_joint_pos_target: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Joint efforts for the command.

        Args:
            jacobian_b: Jacobian of the end effector, shape (num_envs, 6, num_joints).
            current_ee_pose_b: its pose, shape (num_envs, 7).
            current_ee_vel_b: its velocity, shape (num_envs, 6).
            current_ee_force_b: contact force on it in N, shape (num_envs, 3).
            mass_matrix: joint-space inertia, shape (num_envs, num_joints, num_joints).
            gravity: efforts that hold the arm against gravity, shape (num_envs, num_joints).
            current_joint_pos: joint positions, shape (num_envs, num_joints).
            current_joint_vel: joint velocities, shape (num_envs, num_joints).
            nullspace_joint_pos_target: joint positions that the free motion is pulled to; None pulls to zero.

        Returns:
            Efforts in N m or N, shape (num_envs, num_joints).

        Raises:
            ConfigError: an argument that the config makes necessary is missing, or the arm is not redundant.
        """
        jacobian_t = jacobian_b.mT
        efforts = torch.zeros(self.num_envs, jacobian_b.shape[2], device=self._device)
        decoupling = self.cfg.inertial_dynamics_decoupling
        inertia: torch.Tensor | None = None
        if self.desired_ee_pose_b is not None:
            pose = _needed(current_ee_pose_b, "motion control", "current_ee_pose_b")
            velocity = _needed(current_ee_vel_b, "motion control", "current_ee_vel_b")
            wanted = self.desired_ee_pose_b
            error = torch.cat(
                compute_pose_error(pose[:, :3], pose[:, 3:], wanted[:, :3], wanted[:, 3:], rot_error_type="axis_angle"),
                dim=-1,
            )
            acceleration = self._to_b(self._stiffness * self._to_task(error) - self._damping * self._to_task(velocity))
            force = acceleration
            if decoupling:
                inertia = self._task_inertia(
                    jacobian_b, _needed(mass_matrix, "inertial_dynamics_decoupling", "mass_matrix")
                )
                force = _apply(inertia, acceleration)
            efforts += _apply(jacobian_t, self._to_b(self._motion_axes * self._to_task(force)))
        if self.desired_ee_wrench_b is not None:
            wrench = self.desired_ee_wrench_b
            if self._wrench_gain is not None:
                measured = _needed(current_ee_force_b, "contact_wrench_stiffness_task", "current_ee_force_b")
                # only forces are measured: the moments stay open-loop
                error = torch.cat((wrench[:, :3] - measured, torch.zeros_like(measured)), dim=-1)
                wrench = wrench + self._to_b(self._wrench_gain * self._to_task(error))
            efforts += _apply(jacobian_t, self._to_b(self._wrench_axes * self._to_task(wrench)))
        if self.cfg.gravity_compensation:
            efforts += _needed(gravity, "gravity_compensation", "gravity")
        if self.cfg.nullspace_control == "position":
            efforts += self._nullspace_efforts(
                jacobian_b,
                inertia,
                mass_matrix,
                _needed(current_joint_pos, "nullspace_control", "current_joint_pos"),
                _needed(current_joint_vel, "nullspace_control", "current_joint_vel"),
                nullspace_joint_pos_target,
            )
        return efforts

    def _task_inertia(self, jacobian_b: torch.Tensor, mass_matrix: torch.Tensor) -> torch.Tensor:
        """(J M^-1 J^T)^-1, shape (num_envs, 6, 6), without its coupling blocks if the config says so."""
        mobility = jacobian_b @ torch.linalg.solve(mass_matrix, jacobian_b.mT)
        if not self.cfg.partial_inertial_dynamics_decoupling:
            return _inverse(mobility)
        inertia = torch.zeros_like(mobility)
        inertia[:, :3, :3] = _inverse(mobility[:, :3, :3])
        inertia[:, 3:, 3:] = _inverse(mobility[:, 3:, 3:])
        return inertia

    def _nullspace_efforts(
        self,
        jacobian_b: torch.Tensor,
        inertia: torch.Tensor | None,
        mass_matrix: torch.Tensor | None,
        joint_pos: torch.Tensor,
        joint_vel: torch.Tensor,
        target: torch.Tensor | None,
    ) -> torch.Tensor:
        """Efforts of a joint-space spring, projected so that they do not move the end effector."""
        num_joints = jacobian_b.shape[2]
        if num_joints <= 6:
            raise ConfigError(f"nullspace_control needs a redundant arm; this one has {num_joints} joints")
        if inertia is not None and not self.cfg.partial_inertial_dynamics_decoupling:
            # the dynamically consistent inverse
            inverse_t = inertia @ torch.linalg.solve(mass_matrix, jacobian_b.mT).mT
        else:
            inverse_t = torch.linalg.pinv(jacobian_b).mT
        projector = torch.eye(num_joints, device=self._device) - jacobian_b.mT @ inverse_t
        stiffness = self.cfg.nullspace_stiffness
        damping = 2.0 * stiffness**0.5 * self.cfg.nullspace_damping_ratio
        pull = -joint_pos if target is None else target - joint_pos
        acceleration = stiffness * pull - damping * joint_vel
        return _apply(projector, acceleration if mass_matrix is None else _apply(mass_matrix, acceleration))

    def _to_b(self, vector_task: torch.Tensor) -> torch.Tensor:
        """Both halves of a six-vector turned from the task frame into the root frame."""
        return (vector_task.view(-1, 2, 3) @ self._rot_task_to_b.mT).reshape(-1, 6)

    def _to_task(self, vector_b: torch.Tensor) -> torch.Tensor:
        """Both halves of a six-vector turned from the root frame into the task frame."""
        return (vector_b.view(-1, 2, 3) @ self._rot_task_to_b).reshape(-1, 6)


def _inverse(matrix: torch.Tensor) -> torch.Tensor:
    """Inverse; an environment whose matrix is singular gets infinities and does not stop the others."""
    return torch.linalg.inv_ex(matrix).inverse


def _apply(matrix: torch.Tensor, vector: torch.Tensor) -> torch.Tensor:
    return (matrix @ vector.unsqueeze(-1)).squeeze(-1)


def _needed(value: torch.Tensor | None, feature: str, name: str) -> torch.Tensor:
    if value is None:
        raise ConfigError(f"{feature} needs {name}")
    return value
