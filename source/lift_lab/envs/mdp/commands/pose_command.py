"""A pose drawn uniformly, in a robot's root frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.managers import CommandTerm
from lift_lab.markers import VisualizationMarkers
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.versions import version_of

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

    Metrics: ``position_error`` (m) and ``orientation_error`` (rad) of the body to the commanded pose, as they were at
    the last step. They are computed at every step, so they are kept cheap: the commanded pose in the world changes
    only with the command where the robot's base is fixed, and the angle follows from the distance of the quaternions.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_placed"})

    cfg: UniformPoseCommandCfg

    pose_command_b: torch.Tensor
    """Commanded pose (m, wxyz) in the root frame, shape (num_envs, 7)."""

    pose_command_w: torch.Tensor
    """Commanded pose (m, wxyz) in the world frame, shape (num_envs, 7)."""

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
        self._placed: tuple[torch.Tensor, int | None] | None = None
        self._is_measured = False
        self._no_rotation = math_utils.default_orientation(1, self.device)
        self._in_rows(("position_error", "orientation_error"))

    @property
    def command(self) -> torch.Tensor:
        """The commanded pose (m, wxyz) in the root frame, shape (num_envs, 7)."""
        return self.pose_command_b

    @property
    def goal_pos_w(self) -> torch.Tensor:
        """The commanded position in the world frame at the present state in m, shape (num_envs, 3)."""
        self._place_commands()
        return self.pose_command_w[:, :3]

    def finish_episodes(self, env_ids: torch.Tensor) -> None:
        """Measure the last step of the episodes that end; a subclass with metrics of its own does so itself."""
        if type(self)._update_metrics is UniformPoseCommand._update_metrics:
            self._measure_once()

    def _update_metrics(self) -> None:
        self._measure_once()
        self._is_measured = False

    def _measure_once(self) -> None:
        """Measure the step just taken, unless this was done before its resets."""
        if not self._is_measured:
            self._measure()
            self._is_measured = True

    def _measure(self) -> None:
        """Write the metrics of the step just taken, of all environments."""
        self._place_commands()
        wanted_pos, wanted_quat = self.pose_command_w.split_with_sizes((3, 4), dim=-1)
        pos, quat = self.robot.data.link_pose_of(self.body_idx)
        metrics = self.metrics
        torch.linalg.vector_norm(wanted_pos - pos, dim=-1, out=metrics["position_error"])
        apart = torch.minimum(
            torch.linalg.vector_norm(wanted_quat - quat, dim=-1),
            torch.linalg.vector_norm(wanted_quat + quat, dim=-1),
        )
        # unit quaternions an angle t apart are a chord of 2 sin(t / 4) apart
        torch.mul(apart.mul_(0.5).clamp_(max=1.0).asin_(), 4.0, out=metrics["orientation_error"])

    def _resample_command(self, env_ids: torch.Tensor) -> None:
        r = self.cfg.ranges
        drawn = sample_ranges((r.pos_x, r.pos_y, r.pos_z, r.roll, r.pitch, r.yaw), len(env_ids), self.device)
        if is_zero((r.roll, r.pitch, r.yaw)):
            quat = self._no_rotation.expand(len(env_ids), -1)
        else:
            quat = math_utils.quat_from_euler_xyz(drawn[:, 3], drawn[:, 4], drawn[:, 5])
        if self.cfg.make_quat_unique:
            quat = math_utils.quat_unique(quat)
        rows = slice(None) if self._written() else env_ids
        self.pose_command_b[env_ids] = torch.cat((self._choose_positions(env_ids, drawn[:, :3]), quat), dim=-1)
        self._update_world_pose(rows)

    def _choose_positions(self, env_ids: torch.Tensor, uniform_b: torch.Tensor) -> torch.Tensor:
        """What to command some environments, in m in the root frame, where these were drawn: both of shape (n, 3)."""
        return uniform_b

    def _update_command(self) -> None:
        pass

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

    def on_state_loaded(self) -> None:
        """Put the commands of a saved state into the world."""
        self._placed = None

    def _place_commands(self) -> None:
        """Bring :attr:`pose_command_w` up to date where the robot moves or somebody wrote a command."""
        if self.robot.has_movable_root or self._written():
            self._update_world_pose(slice(None))

    def _update_world_pose(self, env_ids: torch.Tensor | slice) -> None:
        data, command = self.robot.data, self.pose_command_b[env_ids]
        pos_w, pos_b, quat_b = data.root_pos_w[env_ids], command[:, :3], command[:, 3:]
        if data.root_is_aligned:
            pose = pos_w + pos_b, quat_b
        else:
            pose = math_utils.combine_frame_transforms(pos_w, data.root_quat_w[env_ids], pos_b, quat_b)
        self.pose_command_w[env_ids] = torch.cat(pose, dim=-1)
        self._placed = self.pose_command_b, version_of(self.pose_command_b)

    def _written(self) -> bool:
        """Whether anybody else wrote commands since they were last put into the world, as far as that can be told."""
        if self._placed is None:
            return True
        command, version = self._placed
        return command is not self.pose_command_b or version is None or version != version_of(command)
