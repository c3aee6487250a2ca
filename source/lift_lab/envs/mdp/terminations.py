"""Termination terms, with Isaac Lab's names: functions ``(env, **params) -> bool tensor`` of shape (num_envs,)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils.indexing import columns
from lift_lab.utils.ranges import COUNT, FINITE, NOT_NEGATIVE, SPAN_OR_INF

if TYPE_CHECKING:
    from lift_lab.assets import Articulation, RigidObject
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.sensors import ContactSensor

__all__ = [
    "bad_orientation",
    "command_resample",
    "illegal_contact",
    "joint_effort_out_of_limit",
    "joint_pos_out_of_limit",
    "joint_pos_out_of_manual_limit",
    "joint_vel_out_of_limit",
    "joint_vel_out_of_manual_limit",
    "root_height_below_minimum",
    "time_out",
]


def time_out(env: ManagerBasedRLEnv) -> torch.Tensor:
    """The episode has its full length."""
    return env.episode_length_buf >= env.max_episode_length


def command_resample(
    env: ManagerBasedRLEnv, command_name: str, num_resamples: Annotated[int, COUNT] = 1
) -> torch.Tensor:
    """The command is about to be resampled after ``num_resamples`` samples in this episode."""
    command = env.command_manager.get_term(command_name)
    return (command.time_left <= env.step_dt) & (command.command_counter == num_resamples)


# -- root


def bad_orientation(
    env: ManagerBasedRLEnv, limit_angle: Annotated[float, FINITE], asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")
) -> torch.Tensor:
    """The root's z axis leans away from the vertical by more than ``limit_angle`` (rad)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return torch.acos((-asset.data.projected_gravity_b[:, 2]).clamp(-1.0, 1.0)) > limit_angle


def root_height_below_minimum(
    env: ManagerBasedRLEnv,
    minimum_height: Annotated[float, FINITE],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> torch.Tensor:
    """The root is lower than ``minimum_height`` (m, world frame)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_pos_w[:, 2] < minimum_height


# -- joints


def joint_pos_out_of_limit(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """A chosen joint is beyond its soft position limits."""
    asset: Articulation = env.scene[asset_cfg.name]
    limits = columns(asset.data.soft_joint_pos_limits, asset_cfg.joint_ids)
    position = columns(asset.data.joint_pos, asset_cfg.joint_ids)
    return ((position > limits[..., 1]) | (position < limits[..., 0])).any(dim=1)


def joint_pos_out_of_manual_limit(
    env: ManagerBasedRLEnv,
    bounds: Annotated[tuple[float, float], SPAN_OR_INF],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> torch.Tensor:
    """A chosen joint is outside ``bounds`` (rad or m)."""
    asset: Articulation = env.scene[asset_cfg.name]
    position = columns(asset.data.joint_pos, asset_cfg.joint_ids)
    return ((position > bounds[1]) | (position < bounds[0])).any(dim=1)


def joint_vel_out_of_limit(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """A chosen joint is faster than its soft velocity limit."""
    asset: Articulation = env.scene[asset_cfg.name]
    limits = columns(asset.data.soft_joint_vel_limits, asset_cfg.joint_ids)
    return (columns(asset.data.joint_vel, asset_cfg.joint_ids).abs() > limits).any(dim=1)


def joint_vel_out_of_manual_limit(
    env: ManagerBasedRLEnv,
    max_velocity: Annotated[float, NOT_NEGATIVE],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> torch.Tensor:
    """A chosen joint is faster than ``max_velocity`` (rad/s or m/s)."""
    asset: Articulation = env.scene[asset_cfg.name]
    return (columns(asset.data.joint_vel, asset_cfg.joint_ids).abs() > max_velocity).any(dim=1)


def joint_effort_out_of_limit(
    env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")
) -> torch.Tensor:
    """The effort wanted of a chosen joint was clipped, seen as a difference between wanted and applied effort."""
    asset: Articulation = env.scene[asset_cfg.name]
    wanted = columns(asset.data.computed_torque, asset_cfg.joint_ids)
    applied = columns(asset.data.applied_torque, asset_cfg.joint_ids)
    return (~torch.isclose(wanted, applied)).any(dim=1)


# -- contact


def illegal_contact(
    env: ManagerBasedRLEnv, threshold: Annotated[float, FINITE], sensor_cfg: SceneEntityCfg
) -> torch.Tensor:
    """A chosen body of a contact sensor felt more than ``threshold`` (N) within the sensor's history."""
    sensor: ContactSensor = env.scene.sensors[sensor_cfg.name]
    # shape (num_envs, history, num_bodies)
    magnitude = sensor.data.net_forces_w_history.norm(dim=-1)
    return (columns(magnitude.amax(dim=1), sensor_cfg.body_ids) > threshold).any(dim=1)
