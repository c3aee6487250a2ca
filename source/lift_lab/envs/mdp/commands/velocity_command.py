"""Planar velocities for a base to follow, in its root frame."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import torch

from lift_lab.managers import CommandTerm, MetricsTermCfg
from lift_lab.markers import VisualizationMarkers
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError

from ..metrics import command_velocity_error_xy, command_velocity_error_yaw
from ..sampling import sample_ranges

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv

    from .commands_cfg import NormalVelocityCommandCfg, UniformVelocityCommandCfg

__all__ = [
    "NormalVelocityCommand",
    "UniformVelocityCommand",
]

logger = logging.getLogger(__name__)

_ARROW_HEIGHT_M = 0.5
"""Height of the markers above the root."""
_ARROW_PER_SPEED = 3.0
"""Stretch of a marker per m/s, as Isaac Lab draws it."""


class UniformVelocityCommand(CommandTerm):
    """Forward velocity, sideways velocity and yaw rate, drawn uniformly.

    With ``heading_command`` the yaw rate steers towards a drawn heading instead. Metrics: ``error_vel_xy`` (m/s) and
    ``error_vel_yaw`` (rad/s), averaged over the time that a command can last.
    """

    def __init__(self, cfg: UniformVelocityCommandCfg, env: ManagerBasedRLEnv):
        """Find the asset.

        Raises:
            ConfigError: ``heading_command`` without ``ranges.heading``.
        """
        super().__init__(cfg, env)
        heading = getattr(cfg.ranges, "heading", None)
        if cfg.heading_command and heading is None:
            raise ConfigError("the velocity command has heading_command=True but ranges.heading is None")
        if heading is not None and not cfg.heading_command:
            logger.warning("the velocity command's ranges.heading is not used: heading_command is False")
        self.robot: Articulation = env.scene[cfg.asset_name]
        self.vel_command_b = torch.zeros(self.num_envs, 3, device=self.device)
        """Commanded velocity (m/s, m/s, rad/s) in the root frame, shape (num_envs, 3)."""
        self.heading_target = torch.zeros(self.num_envs, device=self.device)
        """Commanded heading in the world frame in rad, shape (num_envs,)."""
        self.is_heading_env = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)
        """Where the yaw rate steers towards the heading, shape (num_envs,)."""
        self.is_standing_env = torch.zeros_like(self.is_heading_env)
        """Where the command is to stand still, shape (num_envs,)."""

    @property
    def command(self) -> torch.Tensor:
        """The commanded velocity (m/s, m/s, rad/s) in the root frame, shape (num_envs, 3)."""
        return self.vel_command_b

    def metrics_terms(self, command_name: str) -> dict[str, MetricsTermCfg]:
        """Errors of horizontal velocity and yaw rate, summed over the episode."""
        params = {"command_name": command_name}
        return {
            "error_vel_xy": MetricsTermCfg(func=command_velocity_error_xy, params=params, reduce="sum"),
            "error_vel_yaw": MetricsTermCfg(func=command_velocity_error_yaw, params=params, reduce="sum"),
        }

    def _resample_command(self, env_ids: torch.Tensor) -> None:
        r, count = self.cfg.ranges, len(env_ids)
        ranges = (r.lin_vel_x, r.lin_vel_y, r.ang_vel_z)
        self.vel_command_b[env_ids] = sample_ranges(ranges, count, self.device)
        if self.cfg.heading_command and r.heading is not None:
            self.heading_target[env_ids] = sample_ranges((r.heading,), count, self.device)[:, 0]
            self.is_heading_env[env_ids] = self._chance(count, self.cfg.rel_heading_envs)
        self.is_standing_env[env_ids] = self._chance(count, self.cfg.rel_standing_envs)

    def _chance(self, count: int, probability: float) -> torch.Tensor:
        """True with a probability, shape (count,)."""
        return torch.rand(count, device=self.device) < probability

    def _update_command(self) -> None:
        if self.cfg.heading_command:
            error = math_utils.wrap_to_pi(self.heading_target - self.robot.data.heading_w)
            rate = (self.cfg.heading_control_stiffness * error).clamp(*self.cfg.ranges.ang_vel_z)
            self.vel_command_b[:, 2] = torch.where(self.is_heading_env, rate, self.vel_command_b[:, 2])
        self.vel_command_b.masked_fill_(self.is_standing_env.unsqueeze(1), 0.0)

    def _set_debug_vis_impl(self, debug_vis: bool) -> None:
        if not hasattr(self, "goal_vel_visualizer"):
            self.goal_vel_visualizer = VisualizationMarkers(self.cfg.goal_vel_visualizer_cfg)
            self.current_vel_visualizer = VisualizationMarkers(self.cfg.current_vel_visualizer_cfg)
        self.goal_vel_visualizer.set_visibility(debug_vis)
        self.current_vel_visualizer.set_visibility(debug_vis)

    def _debug_vis_callback(self, event: Any) -> None:
        data = self.robot.data
        above = data.root_pos_w + torch.tensor((0.0, 0.0, _ARROW_HEIGHT_M), device=self.device)
        for markers, velocity_b in (
            (self.goal_vel_visualizer, self.vel_command_b[:, :2]),
            (self.current_vel_visualizer, data.root_lin_vel_b[:, :2]),
        ):
            zeros = torch.zeros_like(velocity_b[:, 0])
            turn = math_utils.quat_from_euler_xyz(zeros, zeros, torch.atan2(velocity_b[:, 1], velocity_b[:, 0]))
            scales = torch.ones(self.num_envs, 3, device=self.device)
            scales[:, 0] = _ARROW_PER_SPEED * velocity_b.norm(dim=1)
            markers.visualize(above, math_utils.quat_mul(data.root_quat_w, turn), scales)


class NormalVelocityCommand(UniformVelocityCommand):
    """Forward velocity, sideways velocity and yaw rate, drawn from normal distributions with a random sign."""

    cfg: NormalVelocityCommandCfg

    def __init__(self, cfg: NormalVelocityCommandCfg, env: ManagerBasedRLEnv):
        """Find the asset.

        Raises:
            ConfigError: ``heading_command`` is set, which a normal distribution has no use for.
        """
        if cfg.heading_command:
            raise ConfigError("NormalVelocityCommand has no heading: leave heading_command=False")
        super().__init__(cfg, env)
        self.is_zero_vel_env = torch.zeros(self.num_envs, 3, dtype=torch.bool, device=self.device)
        """Which components are zero, shape (num_envs, 3)."""

    def _resample_command(self, env_ids: torch.Tensor) -> None:
        r, shape = self.cfg.ranges, (len(env_ids), 3)
        mean, std, zero = (
            torch.tensor(v, dtype=torch.float32, device=self.device) for v in (r.mean_vel, r.std_vel, r.zero_prob)
        )
        drawn = mean + std * torch.randn(shape, device=self.device)
        sign = torch.where(torch.rand(shape, device=self.device) < 0.5, 1.0, -1.0)
        self.vel_command_b[env_ids] = drawn * sign
        self.is_zero_vel_env[env_ids] = torch.rand(shape, device=self.device) < zero
        self.is_standing_env[env_ids] = self._chance(len(env_ids), self.cfg.rel_standing_envs)

    def _update_command(self) -> None:
        self.vel_command_b.masked_fill_(self.is_zero_vel_env | self.is_standing_env.unsqueeze(1), 0.0)
