"""Event terms that put assets into a state at a reset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils import math as math_utils
from lift_lab.utils.indexing import EnvIds, block
from lift_lab.utils.ranges import SPAN, Range

from ..sampling import POSE_AXES, axis_ranges, is_zero, sample_axis, sample_offsets_outside, sample_ranges

if TYPE_CHECKING:
    from lift_lab.assets import Articulation, DeformableObject, RigidObject
    from lift_lab.envs import ManagerBasedEnv

__all__ = [
    "reset_joints_by_offset",
    "reset_joints_by_scale",
    "reset_nodal_state_outside",
    "reset_nodal_state_uniform",
    "reset_root_state_outside",
    "reset_root_state_uniform",
    "reset_root_state_with_random_orientation",
    "reset_scene_to_default",
]


def reset_scene_to_default(env: ManagerBasedEnv, env_ids: EnvIds, reset_joint_targets: bool = False) -> None:
    """Put every asset of the scene into its default state; a fixed base stays where it is.

    Args:
        env: the environment.
        env_ids: environments to reset.
        reset_joint_targets: whether joint targets are set to the default joint state, too.
    """
    for rigid_object in env.scene.rigid_objects.values():
        rigid_object.write_default_root_state_to_sim(env_ids)
    for deformable in env.scene.deformable_objects.values():
        deformable.write_nodal_state_to_sim(block(deformable.data.default_nodal_state_w, env_ids), env_ids=env_ids)
    for articulation in env.scene.articulations.values():
        if articulation.has_movable_root:
            articulation.write_default_root_state_to_sim(env_ids)
        position = block(articulation.data.default_joint_pos, env_ids)
        velocity = block(articulation.data.default_joint_vel, env_ids)
        articulation.write_joint_state_to_sim(position, velocity, env_ids=env_ids)
        if reset_joint_targets:
            articulation.set_joint_position_target(position, env_ids=env_ids)
            articulation.set_joint_velocity_target(velocity, env_ids=env_ids)


def reset_root_state_uniform(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    pose_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    velocity_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """Put an asset's root near its default pose and velocity, the differences drawn uniformly.

    Args:
        env: the environment.
        env_ids: environments to reset.
        pose_range: (low, high) for any of ``x, y, z`` (m) and ``roll, pitch, yaw`` (rad). The rotation is applied
            in the root's own frame, after the default orientation.
        velocity_range: (low, high) for any of the same axes, in m/s and rad/s, world frame.
        asset_cfg: the asset.

    Raises:
        ConfigError: a range names an axis that does not exist.
    """
    asset: RigidObject | Articulation = env.scene[asset_cfg.name]
    state = block(asset.data.default_root_state, env_ids)
    position = state[:, :3].add_(block(env.scene.env_origins, env_ids))
    ranges = axis_ranges(pose_range, "reset_root_state_uniform: pose_range")
    if is_zero(ranges[3:]):
        position += sample_ranges(ranges[:3], len(state), env.device)
    else:
        delta = sample_ranges(ranges, len(state), env.device)
        position += delta[:, :3]
        rotation = math_utils.quat_from_euler_xyz(delta[:, 3], delta[:, 4], delta[:, 5])
        state[:, 3:7] = math_utils.quat_mul(state[:, 3:7], rotation)
    _add_velocity(state, velocity_range, "reset_root_state_uniform: velocity_range", env.device)
    asset.write_root_state_to_sim(state, env_ids=env_ids)


def reset_root_state_with_random_orientation(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    pose_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    velocity_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """As :func:`reset_root_state_uniform`, with the orientation drawn uniformly from all rotations.

    Args:
        env: the environment.
        env_ids: environments to reset.
        pose_range: (low, high) for any of ``x, y, z`` (m).
        velocity_range: (low, high) for any of ``x, y, z`` (m/s) and ``roll, pitch, yaw`` (rad/s).
        asset_cfg: the asset.

    Raises:
        ConfigError: a range names an axis that does not exist.
    """
    asset: RigidObject | Articulation = env.scene[asset_cfg.name]
    state = block(asset.data.default_root_state, env_ids)
    what = "reset_root_state_with_random_orientation"
    ranges = axis_ranges(pose_range, f"{what}: pose_range", axes=("x", "y", "z"))
    state[:, :3] += block(env.scene.env_origins, env_ids) + sample_ranges(ranges, len(state), env.device)
    state[:, 3:7] = math_utils.random_orientation(len(state), device=env.device)
    _add_velocity(state, velocity_range, f"{what}: velocity_range", env.device)
    asset.write_root_state_to_sim(state, env_ids=env_ids)


def _add_velocity(state: torch.Tensor, velocity_range: Mapping[str, Sequence[float]], what: str, device: str) -> None:
    ranges = axis_ranges(velocity_range, what)
    if not is_zero(ranges):
        state[:, 7:] += sample_ranges(ranges, len(state), device)


def reset_nodal_state_uniform(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    position_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    velocity_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """Put a deformable object near its default state: all nodes are moved alike, by amounts drawn uniformly.

    Args:
        env: the environment.
        env_ids: environments to reset.
        position_range: (low, high) for any of ``x, y, z`` in m.
        velocity_range: (low, high) for any of ``x, y, z`` in m/s.
        asset_cfg: the deformable object.

    Raises:
        ConfigError: a range names an axis that does not exist.
    """
    asset: DeformableObject = env.scene[asset_cfg.name]
    state = block(asset.data.default_nodal_state_w, env_ids)
    for columns, ranges, what in (
        (slice(0, 3), position_range, "position_range"),
        (slice(3, 6), velocity_range, "velocity_range"),
    ):
        bounds = axis_ranges(ranges, f"reset_nodal_state_uniform: {what}", axes=("x", "y", "z"))
        if not is_zero(bounds):
            state[..., columns] += sample_ranges(bounds, len(state), env.device)[:, None]
    asset.write_nodal_state_to_sim(state, env_ids=env_ids)


def reset_root_state_outside(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    pose_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    velocity_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    factor: Annotated[float, Range(1.0, above=True)],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """As :func:`reset_root_state_uniform`, with positions outside of their range.

    Args:
        env: the environment.
        env_ids: environments to reset.
        pose_range: (low, high) for any of ``x, y, z`` (m) and ``roll, pitch, yaw`` (rad). Positions are drawn outside
            of it and within the range ``factor`` times as wide about the same middle; angles are drawn within it.
        velocity_range: (low, high) for any of the same axes, in m/s and rad/s, world frame.
        factor: above 1.
        asset_cfg: the asset.

    Raises:
        ConfigError: no range of x, y and z has a width.
    """
    asset: RigidObject | Articulation = env.scene[asset_cfg.name]
    state = block(asset.data.default_root_state, env_ids)
    offsets = sample_offsets_outside(pose_range, factor, state, "reset_root_state_outside: pose_range")
    state[:, :3] += block(env.scene.env_origins, env_ids) + offsets
    rotation = math_utils.quat_from_euler_xyz(*(sample_axis(pose_range, axis, state) for axis in POSE_AXES[3:]))
    state[:, 3:7] = math_utils.quat_mul(state[:, 3:7], rotation)
    state[:, 7:] += torch.stack([sample_axis(velocity_range, axis, state) for axis in POSE_AXES], 1)
    asset.write_root_state_to_sim(state, env_ids=env_ids)


def reset_nodal_state_outside(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    position_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    velocity_range: Annotated[Mapping[str, Sequence[float]], SPAN],
    factor: Annotated[float, Range(1.0, above=True)],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """As :func:`reset_nodal_state_uniform`, with positions outside of their range.

    Args:
        env: the environment.
        env_ids: environments to reset.
        position_range: (low, high) for any of ``x, y, z`` in m. Positions are drawn outside of it and within the range
            ``factor`` times as wide about the same middle.
        velocity_range: (low, high) for any of ``x, y, z`` in m/s.
        factor: above 1.
        asset_cfg: the deformable object.

    Raises:
        ConfigError: no range of x, y and z has a width.
    """
    asset: DeformableObject = env.scene[asset_cfg.name]
    state = block(asset.data.default_nodal_state_w, env_ids)
    offsets = sample_offsets_outside(position_range, factor, state, "reset_nodal_state_outside: position_range")
    state[..., :3] += offsets[:, None]
    state[..., 3:] += torch.stack([sample_axis(velocity_range, axis, state) for axis in "xyz"], 1)[:, None]
    asset.write_nodal_state_to_sim(state, env_ids=env_ids)


def reset_joints_by_scale(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    position_range: Annotated[tuple[float, float], SPAN],
    velocity_range: Annotated[tuple[float, float], SPAN],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """Put joints at their default positions and velocities times uniform factors, within the soft limits.

    Args:
        env: the environment.
        env_ids: environments to reset.
        position_range: (low, high) of the factor of each joint's position.
        velocity_range: (low, high) of the factor of each joint's velocity.
        asset_cfg: the articulation and which of its joints.
    """
    asset: Articulation = env.scene[asset_cfg.name]
    position = block(asset.data.default_joint_pos, env_ids, asset_cfg.joint_ids)
    velocity = block(asset.data.default_joint_vel, env_ids, asset_cfg.joint_ids)
    position *= math_utils.sample_uniform(*position_range, position.shape, position.device)
    velocity *= math_utils.sample_uniform(*velocity_range, velocity.shape, velocity.device)
    _write_within_limits(asset, position, velocity, env_ids, asset_cfg)


def reset_joints_by_offset(
    env: ManagerBasedEnv,
    env_ids: EnvIds,
    position_range: Annotated[tuple[float, float], SPAN],
    velocity_range: Annotated[tuple[float, float], SPAN],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> None:
    """Put joints at their default positions and velocities plus uniform differences, within the soft limits.

    Args:
        env: the environment.
        env_ids: environments to reset.
        position_range: (low, high) of the offset of each joint's position, in rad or m.
        velocity_range: (low, high) of the offset of each joint's velocity, in rad/s or m/s.
        asset_cfg: the articulation and which of its joints.
    """
    asset: Articulation = env.scene[asset_cfg.name]
    position = block(asset.data.default_joint_pos, env_ids, asset_cfg.joint_ids)
    velocity = block(asset.data.default_joint_vel, env_ids, asset_cfg.joint_ids)
    position += math_utils.sample_uniform(*position_range, position.shape, position.device)
    velocity += math_utils.sample_uniform(*velocity_range, velocity.shape, velocity.device)
    _write_within_limits(asset, position, velocity, env_ids, asset_cfg)


def _write_within_limits(
    asset: Articulation,
    position: torch.Tensor,
    velocity: torch.Tensor,
    env_ids: EnvIds,
    asset_cfg: SceneEntityCfg,
) -> None:
    limits = block(asset.data.soft_joint_pos_limits, env_ids, asset_cfg.joint_ids)
    speed = block(asset.data.soft_joint_vel_limits, env_ids, asset_cfg.joint_ids)
    position = position.clamp(limits[..., 0], limits[..., 1])
    velocity = velocity.clamp(-speed, speed)
    asset.write_joint_state_to_sim(position, velocity, joint_ids=asset_cfg.joint_ids, env_ids=env_ids)
