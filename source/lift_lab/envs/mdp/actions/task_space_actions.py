"""Actions in task space: an end-effector target becomes joint positions or joint efforts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.assets.articulation.joint_dynamics import JointDynamics
from lift_lab.controllers import DifferentialIKController, OperationalSpaceController
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.indexing import columns
from lift_lab.utils.io_descriptors import GenericActionIODescriptor

from ._end_effector import EndEffector
from .joint_actions import clip_limits, clipped
from .stored_action import StoredAction

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedEnv
    from lift_lab.utils.indexing import EnvIds

    from . import actions_cfg

__all__ = [
    "DifferentialInverseKinematicsAction",
    "OperationalSpaceControllerAction",
]


class DifferentialInverseKinematicsAction(StoredAction):
    """End-effector targets in the root frame, turned into position targets by inverse kinematics.

    The inverse kinematics is solved again at every physics step. Unlike in Isaac Lab's term, the offset of the
    controlled frame is turned into the root frame before it enters the Jacobian.
    """

    cfg: actions_cfg.DifferentialInverseKinematicsActionCfg
    _asset: Articulation

    def __init__(self, cfg: actions_cfg.DifferentialInverseKinematicsActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        self._end_effector = EndEffector(
            self._asset, cfg.joint_names, cfg.body_name, cfg.body_offset, type(self).__name__
        )
        self._ik_controller = DifferentialIKController(cfg.controller, self.num_envs, self.device)
        self._raw_actions = torch.zeros(self.num_envs, self.action_dim, device=self.device)
        self._processed_actions = torch.zeros_like(self._raw_actions)
        self._scale = torch.as_tensor(cfg.scale, dtype=torch.float32, device=self.device)
        if self._scale.ndim and len(self._scale) != self.action_dim:
            raise ConfigError(
                f"{type(self).__name__}: scale has {len(self._scale)} values for {self.action_dim} columns"
            )
        axes = ["x", "y", "z", "rx", "ry", "rz"] if self.action_dim < 7 else ["x", "y", "z", "qw", "qx", "qy", "qz"]
        self._clip = clip_limits(cfg.clip, axes[: self.action_dim], self.num_envs, self.device)

    @property
    def action_dim(self) -> int:
        """Size of the controller's command."""
        return self._ik_controller.action_dim

    @property
    def IO_descriptor(self) -> GenericActionIODescriptor:
        """Adds ``body_name``, ``joint_names``, ``scale`` and ``clip``, and controller and offset in ``extras``."""
        descriptor = super().IO_descriptor
        descriptor.action_type = "TaskSpaceAction"
        descriptor.body_name, descriptor.joint_names = self._end_effector.body_name, self._end_effector.joint_names
        descriptor.scale, descriptor.clip = self._scale, self.cfg.clip
        descriptor.extras |= {"controller_cfg": self.cfg.controller, "body_offset": self.cfg.body_offset}
        return descriptor

    def process_actions(self, actions: torch.Tensor) -> None:
        """Scale and clip the action and command the controller.

        ``clip`` names its columns ``x, y, z`` and ``rx, ry, rz`` (or ``qw, qx, qy, qz``).
        """
        self._raw_actions[:] = actions
        self._processed_actions = clipped(self._raw_actions * self._scale, self._clip)
        self._ik_controller.set_command(self._processed_actions, *self._end_effector.pose_b())

    def apply_actions(self) -> None:
        """Set the position targets."""
        effector = self._end_effector
        target = self._ik_controller.compute(*effector.pose_b(), effector.jacobian_b(), effector.joint_pos)
        self._asset.set_joint_position_target(target, joint_ids=effector.joint_ids)

    def reset(self, env_ids: EnvIds = None) -> None:
        """Forget the raw action of some environments."""
        self._raw_actions[slice(None) if env_ids is None else env_ids] = 0.0


class OperationalSpaceControllerAction(StoredAction):
    """The action holds task-space targets (and gains); operational-space control gives effort targets.

    The joints should have no stiffness and damping of their own. The controller runs at every physics step.
    """

    cfg: actions_cfg.OperationalSpaceControllerActionCfg
    _asset: Articulation

    def __init__(self, cfg: actions_cfg.OperationalSpaceControllerActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        if cfg.controller_cfg.contact_wrench_stiffness_task is not None:
            raise ConfigError(
                f"{type(self).__name__}: contact_wrench_stiffness_task needs forces that the action does not read from"
                " a contact sensor; leave it at None for open-loop wrenches"
            )
        self._end_effector = EndEffector(
            self._asset, cfg.joint_names, cfg.body_name, cfg.body_offset, type(self).__name__
        )
        self._osc = OperationalSpaceController(cfg.controller_cfg, self.num_envs, self.device)
        self._raw_actions = torch.zeros(self.num_envs, self.action_dim, device=self.device)
        self._processed_actions = torch.zeros_like(self._raw_actions)
        self._scale = self._column_scales()
        self._clip = self._gain_limits()
        self._nullspace_target = self._nullspace_joint_positions()
        controller = cfg.controller_cfg
        self._needs_mass = controller.inertial_dynamics_decoupling or controller.nullspace_control == "position"
        self._dynamics: JointDynamics | None = None
        if self._needs_mass or controller.gravity_compensation:
            self._dynamics = JointDynamics(self._asset, self._end_effector.joint_ids)
        self._task_frame = self._find_task_frame(env)

    # -- setting up

    def _column_scales(self) -> torch.Tensor:
        """Factor of each column of the action, shape (action_dim,)."""
        cfg = self.cfg
        scales: list[float] = []
        for target in cfg.controller_cfg.target_types:
            if target == "wrench_abs":
                scales += [cfg.wrench_scale] * 6
            else:
                scales += [cfg.position_scale] * 3 + [cfg.orientation_scale] * (4 if target == "pose_abs" else 3)
        if cfg.controller_cfg.impedance_mode != "fixed":
            scales += [cfg.stiffness_scale] * 6
        if cfg.controller_cfg.impedance_mode == "variable":
            scales += [cfg.damping_ratio_scale] * 6
        return torch.tensor(scales, dtype=torch.float32, device=self.device)

    def _gain_limits(self) -> tuple[torch.Tensor, torch.Tensor]:
        """Bounds of each column: the controller's for gains, none for targets; two tensors of shape (action_dim,)."""
        bounds = torch.tensor([-torch.inf, torch.inf], device=self.device).repeat(self.action_dim, 1)
        first = self._osc.target_dim
        bounds[first : first + 6] = torch.tensor(self.cfg.controller_cfg.motion_stiffness_limits_task)
        bounds[first + 6 :] = torch.tensor(self.cfg.controller_cfg.motion_damping_ratio_limits_task)
        return bounds[:, 0], bounds[:, 1]

    def _nullspace_joint_positions(self) -> torch.Tensor | None:
        """What the free motion is pulled to, shape (num_envs, num_joints); None is zero.

        Raises:
            ConfigError: a target without null-space control, or null-space control without a target.
        """
        choice, control = self.cfg.nullspace_joint_pos_target, self.cfg.controller_cfg.nullspace_control
        if (choice == "none") != (control == "none"):
            raise ConfigError(
                f"{type(self).__name__}: nullspace_joint_pos_target is '{choice}' while the controller's"
                f" nullspace_control is '{control}': set both or neither"
            )
        data, ids = self._asset.data, self._end_effector.joint_ids
        if choice == "center":
            return columns(data.soft_joint_pos_limits, ids).mean(dim=-1)
        if choice == "default":
            return columns(data.default_joint_pos, ids)
        if choice not in ("none", "zero"):
            raise ConfigError(
                f"{type(self).__name__}: nullspace_joint_pos_target must be none, zero, default or center,"
                f" not '{choice}'"
            )
        return None

    def _find_task_frame(self, env: ManagerBasedEnv):
        """The scene's rigid object at ``task_frame_rel_path``, or None."""
        path = self.cfg.task_frame_rel_path
        if path is None:
            return None
        for asset in env.scene.rigid_objects.values():
            if asset.cfg.prim_path.endswith(f"/{path.strip('/')}"):
                return asset
        known = [asset.cfg.prim_path.rsplit("/", 1)[-1] for asset in env.scene.rigid_objects.values()]
        raise ConfigError(
            f"{type(self).__name__}: no rigid object is at task_frame_rel_path '{path}'; the scene has {known}"
        )

    # -- running

    @property
    def action_dim(self) -> int:
        """Size of the controller's command."""
        return self._osc.action_dim

    @property
    def IO_descriptor(self) -> GenericActionIODescriptor:
        """Adds ``body_name``, ``joint_names`` and the scales, and controller and offset in ``extras``."""
        cfg, descriptor = self.cfg, super().IO_descriptor
        descriptor.action_type = "TaskSpaceAction"
        descriptor.body_name, descriptor.joint_names = self._end_effector.body_name, self._end_effector.joint_names
        descriptor.scale = self._scale
        descriptor.position_scale, descriptor.orientation_scale = cfg.position_scale, cfg.orientation_scale
        descriptor.wrench_scale, descriptor.stiffness_scale = cfg.wrench_scale, cfg.stiffness_scale
        descriptor.damping_ratio_scale = cfg.damping_ratio_scale
        descriptor.nullspace_joint_pos_target, descriptor.clip = cfg.nullspace_joint_pos_target, cfg.clip
        descriptor.extras |= {"controller_cfg": cfg.controller_cfg, "body_offset": cfg.body_offset}
        return descriptor

    def process_actions(self, actions: torch.Tensor) -> None:
        """Scale the action and command the controller."""
        self._raw_actions[:] = actions
        self._processed_actions = (self._raw_actions * self._scale).clamp(*self._clip)
        data = self._asset.data
        frame_b = None
        if self._task_frame is not None:
            frame = self._task_frame.data
            frame_b = torch.cat(
                math_utils.subtract_frame_transforms(
                    data.root_pos_w, data.root_quat_w, frame.root_pos_w, frame.root_quat_w
                ),
                dim=-1,
            )
        pose_b = torch.cat(self._end_effector.pose_b(), dim=-1)
        self._osc.set_command(self._processed_actions, pose_b, frame_b)

    def apply_actions(self) -> None:
        """Set the effort targets."""
        effector = self._end_effector
        dynamics = self._dynamics
        efforts = self._osc.compute(
            jacobian_b=effector.jacobian_b(),
            current_ee_pose_b=torch.cat(effector.pose_b(), dim=-1),
            current_ee_vel_b=effector.velocity_b(),
            mass_matrix=dynamics.mass_matrix() if dynamics is not None and self._needs_mass else None,
            gravity=(
                dynamics.gravity_efforts()
                if dynamics is not None and self.cfg.controller_cfg.gravity_compensation
                else None
            ),
            current_joint_pos=effector.joint_pos,
            current_joint_vel=effector.joint_vel,
            nullspace_joint_pos_target=self._nullspace_target,
        )
        self._asset.set_joint_effort_target(efforts, joint_ids=effector.joint_ids)

    def reset(self, env_ids: EnvIds = None) -> None:
        """Forget the raw action of some environments."""
        self._raw_actions[slice(None) if env_ids is None else env_ids] = 0.0
