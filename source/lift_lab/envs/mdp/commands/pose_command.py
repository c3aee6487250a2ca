"""A pose drawn uniformly, in a robot's root frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import torch

from lift_lab.managers import CommandTerm, MetricsTermCfg, SceneEntityCfg
from lift_lab.markers import VisualizationMarkers
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError

from ..metrics import command_orientation_error, command_position_error
from ..sampling import is_zero, sample_ranges

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv

    from .commands_cfg import UniformPoseCommandCfg

__all__ = [
    "UniformPoseCommand",
]


class UniformPoseCommand(CommandTerm):
    """Positions and Euler angles drawn uniformly in the robot's root frame.

    Metrics: ``position_error`` (m) and ``orientation_error`` (rad) of the body to the commanded pose at the last step.
    """

    pose_command_b: torch.Tensor
    """Commanded pose (m, wxyz) in the root frame, shape (num_envs, 7)."""

    pose_command_w: torch.Tensor
    """Commanded pose (m, wxyz) in the world frame when the command was last updated, shape (num_envs, 7)."""

    def __init__(self, cfg: UniformPoseCommandCfg, env: ManagerBasedRLEnv):
        """Find the robot and its body.

        Raises:
            ConfigError: ``body_name`` does not match exactly one body.
        """
        super().__init__(cfg, env)
        self.robot: Articulation = env.scene[cfg.asset_name]
        bodies, names = self.robot.find_bodies(cfg.body_name)
        if len(bodies) != 1:
            raise ConfigError(
                f"UniformPoseCommand: body_name '{cfg.body_name}' must match one body of '{cfg.asset_name}', "
                f"it matches {names}"
            )
        self.body_idx = bodies[0]
        self.pose_command_b = torch.zeros(self.num_envs, 7, device=self.device)
        self.pose_command_b[:, 3] = 1.0
        self.pose_command_w = self.pose_command_b.clone()
        self._no_rotation = math_utils.default_orientation(1, self.device)

    @property
    def command(self) -> torch.Tensor:
        """The commanded pose (m, wxyz) in the root frame, shape (num_envs, 7)."""
        return self.pose_command_b

    @property
    def goal_pos_w(self) -> torch.Tensor:
        """The commanded position in the world frame at the present state in m, shape (num_envs, 3)."""
        self._update_world_pose()
        return self.pose_command_w[:, :3]

    def metrics_terms(self, command_name: str) -> dict[str, MetricsTermCfg]:
        """Position and orientation error of the body."""
        body = SceneEntityCfg(self.cfg.asset_name, body_names=self.cfg.body_name)
        params = {"command_name": command_name, "asset_cfg": body}
        return {
            "position_error": MetricsTermCfg(func=command_position_error, params=params, reduce="last"),
            "orientation_error": MetricsTermCfg(func=command_orientation_error, params=params, reduce="last"),
        }

    def _resample_command(self, env_ids: torch.Tensor) -> None:
        r = self.cfg.ranges
        drawn = sample_ranges((r.pos_x, r.pos_y, r.pos_z, r.roll, r.pitch, r.yaw), len(env_ids), self.device)
        if is_zero((r.roll, r.pitch, r.yaw)):
            quat = self._no_rotation.expand(len(env_ids), -1)
        else:
            quat = math_utils.quat_from_euler_xyz(drawn[:, 3], drawn[:, 4], drawn[:, 5])
        if self.cfg.make_quat_unique:
            quat = math_utils.quat_unique(quat)
        self.pose_command_b[env_ids] = torch.cat((self._choose_positions(env_ids, drawn[:, :3]), quat), dim=-1)
        self._update_world_pose()

    def _choose_positions(self, env_ids: torch.Tensor, uniform_b: torch.Tensor) -> torch.Tensor:
        """What to command some environments, in m in the root frame, where these were drawn: both of shape (n, 3)."""
        return uniform_b

    def _update_command(self) -> None:
        self._update_world_pose()

    def _set_debug_vis_impl(self, debug_vis: bool) -> None:
        if not hasattr(self, "goal_pose_visualizer"):
            self.goal_pose_visualizer = VisualizationMarkers(self.cfg.goal_pose_visualizer_cfg)
            self.current_pose_visualizer = VisualizationMarkers(self.cfg.current_pose_visualizer_cfg)
        self.goal_pose_visualizer.set_visibility(debug_vis)
        self.current_pose_visualizer.set_visibility(debug_vis)

    def _debug_vis_callback(self, event: Any) -> None:
        data = self.robot.data
        self.goal_pose_visualizer.visualize(self.pose_command_w[:, :3], self.pose_command_w[:, 3:])
        self.current_pose_visualizer.visualize(data.body_pos_w[:, self.body_idx], data.body_quat_w[:, self.body_idx])

    def _update_world_pose(self) -> None:
        """Bring :attr:`pose_command_w` up to date, whoever wrote a command or moved the robot."""
        data, pose_b, pose_w = self.robot.data, self.pose_command_b, self.pose_command_w
        if data.root_is_aligned:
            torch.add(data.root_pos_w, pose_b[:, :3], out=pose_w[:, :3])
            pose_w[:, 3:] = pose_b[:, 3:]
        else:
            pose_w[:, :3], pose_w[:, 3:] = math_utils.combine_frame_transforms(
                data.root_pos_w, data.root_quat_w, pose_b[:, :3], pose_b[:, 3:]
            )
