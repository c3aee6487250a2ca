"""A position on the ground and a heading, for a base to reach."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import torch

from lift_lab.managers import CommandTerm, MetricsTermCfg
from lift_lab.markers import VisualizationMarkers
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError

from ..metrics import command_heading_error, command_position_error_2d
from ..sampling import sample_ranges

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv

    from .commands_cfg import UniformPose2dCommandCfg

__all__ = [
    "TerrainBasedPose2dCommand",
    "UniformPose2dCommand",
]


class UniformPose2dCommand(CommandTerm):
    """A position drawn uniformly about the environment's origin, at the root's default height, and a heading.

    With ``simple_heading`` the heading points to or away from the position, whichever is nearer to the current one.
    Metrics: ``error_pos_2d`` (m) and ``error_heading`` (rad) at the last step.
    """

    cfg: UniformPose2dCommandCfg

    def __init__(self, cfg: UniformPose2dCommandCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self.robot: Articulation = env.scene[cfg.asset_name]
        self.pos_command_w = torch.zeros(self.num_envs, 3, device=self.device)
        """Commanded position in the world frame in m, shape (num_envs, 3)."""
        self.heading_command_w = torch.zeros(self.num_envs, device=self.device)
        """Commanded heading in the world frame in rad, shape (num_envs,)."""
        self.pos_command_b = torch.zeros_like(self.pos_command_w)
        """Commanded position in the root's yaw frame in m, shape (num_envs, 3)."""
        self.heading_command_b = torch.zeros_like(self.heading_command_w)
        """Commanded heading less the current one in rad, shape (num_envs,)."""

    @property
    def command(self) -> torch.Tensor:
        """Position in m and heading in rad, as seen from the root's yaw frame, shape (num_envs, 4)."""
        return torch.cat((self.pos_command_b, self.heading_command_b.unsqueeze(1)), dim=1)

    @property
    def goal_pos_w(self) -> torch.Tensor:
        """The commanded position in the world frame in m, shape (num_envs, 3), for viewers."""
        return self.pos_command_w

    def metrics_terms(self, command_name: str) -> dict[str, MetricsTermCfg]:
        """Distance and angle of the root to the command."""
        params = {"command_name": command_name}
        return {
            "error_pos_2d": MetricsTermCfg(func=command_position_error_2d, params=params, reduce="last"),
            "error_heading": MetricsTermCfg(func=command_heading_error, params=params, reduce="last"),
        }

    def _resample_command(self, env_ids: torch.Tensor) -> None:
        r, data = self.cfg.ranges, self.robot.data
        position = self._env.scene.env_origins[env_ids]
        position[:, :2] += sample_ranges((r.pos_x, r.pos_y), len(env_ids), self.device)
        position[:, 2] += data.default_root_state[env_ids, 2]
        self.pos_command_w[env_ids] = position
        if not self.cfg.simple_heading:
            self.heading_command_w[env_ids] = sample_ranges((r.heading,), len(env_ids), self.device)[:, 0]
            return
        way = position - data.root_pos_w[env_ids]
        towards = torch.atan2(way[:, 1], way[:, 0])
        away = math_utils.wrap_to_pi(towards + torch.pi)
        current = data.heading_w[env_ids]
        nearer = math_utils.wrap_to_pi(towards - current).abs() < math_utils.wrap_to_pi(away - current).abs()
        self.heading_command_w[env_ids] = torch.where(nearer, towards, away)

    def _update_command(self) -> None:
        data = self.robot.data
        yaw_frame = math_utils.yaw_quat(data.root_quat_w)
        self.pos_command_b[:] = math_utils.quat_apply_inverse(yaw_frame, self.pos_command_w - data.root_pos_w)
        self.heading_command_b[:] = math_utils.wrap_to_pi(self.heading_command_w - data.heading_w)

    def _set_debug_vis_impl(self, debug_vis: bool) -> None:
        if not hasattr(self, "goal_pose_visualizer"):
            self.goal_pose_visualizer = VisualizationMarkers(self.cfg.goal_pose_visualizer_cfg)
        self.goal_pose_visualizer.set_visibility(debug_vis)

    def _debug_vis_callback(self, event: Any) -> None:
        zeros = torch.zeros_like(self.heading_command_w)
        self.goal_pose_visualizer.visualize(
            self.pos_command_w, math_utils.quat_from_euler_xyz(zeros, zeros, self.heading_command_w)
        )


class TerrainBasedPose2dCommand(UniformPose2dCommand):
    """A position drawn from the flat patches of a generated terrain: making one raises."""

    def __init__(self, cfg: UniformPose2dCommandCfg, env: ManagerBasedRLEnv):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError("mdp.TerrainBasedPose2dCommand needs a generated terrain; use UniformPose2dCommandCfg")
