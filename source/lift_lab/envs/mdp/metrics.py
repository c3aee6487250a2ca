"""Metrics terms: how commands are followed and how smoothly a robot moves, of shape (num_envs,) at every step.

:class:`~lift_lab.managers.MetricsManager` calls them after the rewards, before episodes end.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

from lift_lab.managers import ManagerTermBase, MetricsTermCfg, SceneEntityCfg
from lift_lab.utils import math as math_utils
from lift_lab.utils.indexing import block, columns
from lift_lab.utils.step_cache import once_a_step

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedRLEnv

__all__ = [
    "command_heading_error",
    "command_orientation_error",
    "command_pos_w",
    "command_position_error",
    "command_position_error_2d",
    "command_velocity_error_xy",
    "command_velocity_error_yaw",
    "squared_joint_acceleration",
]

# -- poses


@once_a_step
def command_pos_w(env: ManagerBasedRLEnv, command_name: str, asset_name: str) -> torch.Tensor:
    """A commanded position, which is in the root frame of an asset, in the world frame in m, shape (num_envs, 3)."""
    data = env.scene[asset_name].data
    pos_b = env.command_manager.get_command(command_name)[:, :3]
    return data.root_pos_w + (pos_b if data.root_is_aligned else math_utils.quat_apply(data.root_quat_w, pos_b))


@once_a_step
def link_pose_w(env: ManagerBasedRLEnv, asset_name: str, body_id: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Position (m) and orientation (wxyz) of a body in the world frame, shapes (num_envs, 3) and (num_envs, 4)."""
    return env.scene[asset_name].data.link_pose_of(body_id)


def command_position_error(env: ManagerBasedRLEnv, command_name: str, asset_cfg: SceneEntityCfg) -> torch.Tensor:
    """Distance in m of the first chosen body to the commanded pose, which is in the asset's root frame."""
    pos_w, _ = link_pose_w(env, asset_cfg.name, _body(asset_cfg))
    return torch.linalg.vector_norm(command_pos_w(env, command_name, asset_cfg.name) - pos_w, dim=-1)


def command_orientation_error(env: ManagerBasedRLEnv, command_name: str, asset_cfg: SceneEntityCfg) -> torch.Tensor:
    """Angle in rad of the first chosen body to the commanded pose, which is in the asset's root frame.

    It follows from the distance of the quaternions: unit quaternions an angle t apart are a chord of 2 sin(t / 4)
    apart.
    """
    data = env.scene[asset_cfg.name].data
    wanted = env.command_manager.get_command(command_name)[:, 3:7]
    if not data.root_is_aligned:
        wanted = math_utils.quat_mul(data.root_quat_w, wanted)
    _, quat = link_pose_w(env, asset_cfg.name, _body(asset_cfg))
    chord = torch.minimum(
        torch.linalg.vector_norm(wanted - quat, dim=-1), torch.linalg.vector_norm(wanted + quat, dim=-1)
    )
    return chord.mul_(0.5).clamp_(max=1.0).asin_().mul_(4.0)


def _body(asset_cfg: SceneEntityCfg) -> int:
    ids = asset_cfg.body_ids
    return 0 if isinstance(ids, slice) else ids[0]


def command_position_error_2d(env: ManagerBasedRLEnv, command_name: str) -> torch.Tensor:
    """Horizontal distance in m of the root to a :class:`UniformPose2dCommand`."""
    term = env.command_manager.get_term(command_name)
    return (term.pos_command_w - term.robot.data.root_pos_w)[:, :2].norm(dim=1)


def command_heading_error(env: ManagerBasedRLEnv, command_name: str) -> torch.Tensor:
    """Angle in rad of the root to the heading of a :class:`UniformPose2dCommand`."""
    term = env.command_manager.get_term(command_name)
    return math_utils.wrap_to_pi(term.heading_command_w - term.robot.data.heading_w).abs()


# -- velocities


def command_velocity_error_xy(env: ManagerBasedRLEnv, command_name: str) -> torch.Tensor:
    """Error in m/s of the horizontal velocity to a :class:`UniformVelocityCommand`, over the steps it can last."""
    term = env.command_manager.get_term(command_name)
    error = (term.vel_command_b[:, :2] - term.robot.data.root_lin_vel_b[:, :2]).norm(dim=-1)
    return error / (term.cfg.resampling_time_range[1] / env.step_dt)


def command_velocity_error_yaw(env: ManagerBasedRLEnv, command_name: str) -> torch.Tensor:
    """Error in rad/s of the yaw rate to a :class:`UniformVelocityCommand`, over the steps it can last."""
    term = env.command_manager.get_term(command_name)
    error = (term.vel_command_b[:, 2] - term.robot.data.root_ang_vel_b[:, 2]).abs()
    return error / (term.cfg.resampling_time_range[1] / env.step_dt)


# -- smoothness


class squared_joint_acceleration(ManagerTermBase):
    """Mean over the joints of the squared acceleration in (rad/s^2)^2 or (m/s^2)^2.

    From the joint velocities of one environment step to the next: that of the whole step, not of a physics step.

    Params:
        asset_cfg: the articulation and its joints.
    """

    def __init__(self, cfg: MetricsTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._asset_cfg = cfg.params.setdefault("asset_cfg", SceneEntityCfg("robot"))
        self._asset: Articulation = env.scene[self._asset_cfg.name]
        self._joint_vel = block(self._asset.data.joint_vel, None, self._asset_cfg.joint_ids)

    def reset(self, env_ids: torch.Tensor | Sequence[int] | slice | None = None) -> None:
        """Begin with the velocities of the new episodes."""
        ids = slice(None) if env_ids is None else env_ids
        self._joint_vel[ids] = block(self._asset.data.joint_vel, ids, self._asset_cfg.joint_ids)

    def __call__(self, env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
        joint_vel = columns(self._asset.data.joint_vel, asset_cfg.joint_ids)
        change = joint_vel - self._joint_vel
        self._joint_vel.copy_(joint_vel)
        return change.square_().mean(dim=1) / env.step_dt**2
