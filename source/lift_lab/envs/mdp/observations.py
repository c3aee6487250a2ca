"""Observation terms, with Isaac Lab's names.

Each is a function ``(env, **params) -> tensor`` of shape (num_envs, dim). The observation manager copies a term's value
before it changes it, so a term may return an asset's own tensor.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.managers import SceneEntityCfg
from lift_lab.utils import math as math_utils
from lift_lab.utils.indexing import columns
from lift_lab.utils.io_descriptors import (
    generic_io_descriptor,
    record_body_names,
    record_dtype,
    record_joint_names,
    record_joint_pos_offsets,
    record_joint_vel_offsets,
    record_shape,
)

if TYPE_CHECKING:
    from lift_lab.assets import Articulation, RigidObject
    from lift_lab.envs import ManagerBasedEnv, ManagerBasedRLEnv
    from lift_lab.sensors import Imu

__all__ = [
    "base_ang_vel",
    "base_lin_vel",
    "base_pos_z",
    "body_pose_w",
    "body_projected_gravity_b",
    "current_time_s",
    "generated_commands",
    "imu_ang_vel",
    "imu_lin_acc",
    "imu_orientation",
    "imu_projected_gravity",
    "joint_effort",
    "joint_pos",
    "joint_pos_limit_normalized",
    "joint_pos_rel",
    "joint_vel",
    "joint_vel_rel",
    "last_action",
    "projected_gravity",
    "remaining_time_s",
    "root_ang_vel_w",
    "root_lin_vel_w",
    "root_pos_w",
    "root_quat_w",
]

_TENSOR = [record_shape, record_dtype]
_BODIES = [*_TENSOR, record_body_names]
_JOINTS = [*_TENSOR, record_joint_names]

# -- root state


@generic_io_descriptor(units="m", axes=["Z"], observation_type="RootState", on_inspect=_TENSOR)
def base_pos_z(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Root height in the world frame in m. Shape is (num_envs, 1)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_pos_w[:, 2:3]


@generic_io_descriptor(units="m/s", axes=["X", "Y", "Z"], observation_type="RootState", on_inspect=_TENSOR)
def base_lin_vel(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Root linear velocity in the root frame in m/s. Shape is (num_envs, 3)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_lin_vel_b


@generic_io_descriptor(units="rad/s", axes=["X", "Y", "Z"], observation_type="RootState", on_inspect=_TENSOR)
def base_ang_vel(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Root angular velocity in the root frame in rad/s. Shape is (num_envs, 3)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_ang_vel_b


@generic_io_descriptor(units="unit", axes=["X", "Y", "Z"], observation_type="RootState", on_inspect=_TENSOR)
def projected_gravity(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Unit vector of gravity in the root frame. Shape is (num_envs, 3)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.projected_gravity_b


@generic_io_descriptor(units="m", axes=["X", "Y", "Z"], observation_type="RootState", on_inspect=_TENSOR)
def root_pos_w(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Root position in the environment's frame (world axes, origin of the environment) in m. Shape is (num_envs, 3)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_pos_w - env.scene.env_origins


@generic_io_descriptor(units="unit", axes=["W", "X", "Y", "Z"], observation_type="RootState", on_inspect=_TENSOR)
def root_quat_w(
    env: ManagerBasedEnv, make_quat_unique: bool = False, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")
) -> torch.Tensor:
    """Root orientation (w, x, y, z) in the world frame. Shape is (num_envs, 4).

    Args:
        env: the environment.
        make_quat_unique: whether to turn q into -q where its real part is negative.
        asset_cfg: the asset.
    """
    asset: RigidObject = env.scene[asset_cfg.name]
    quat = asset.data.root_quat_w
    return math_utils.quat_unique(quat) if make_quat_unique else quat


@generic_io_descriptor(units="m/s", axes=["X", "Y", "Z"], observation_type="RootState", on_inspect=_TENSOR)
def root_lin_vel_w(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Root linear velocity in the world frame in m/s. Shape is (num_envs, 3)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_lin_vel_w


@generic_io_descriptor(units="rad/s", axes=["X", "Y", "Z"], observation_type="RootState", on_inspect=_TENSOR)
def root_ang_vel_w(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Root angular velocity in the world frame in rad/s. Shape is (num_envs, 3)."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_ang_vel_w


# -- body state


@generic_io_descriptor(observation_type="BodyState", on_inspect=_BODIES)
def body_pose_w(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Poses (position in m, quaternion wxyz) of the chosen bodies in the environment's frame.

    Returns:
        Body after body, shape (num_envs, 7 * num_bodies).
    """
    asset: Articulation = env.scene[asset_cfg.name]
    position = columns(asset.data.body_pos_w, asset_cfg.body_ids) - env.scene.env_origins.unsqueeze(1)
    quat = columns(asset.data.body_quat_w, asset_cfg.body_ids)
    return torch.cat((position, quat), dim=-1).reshape(env.num_envs, -1)


@generic_io_descriptor(observation_type="BodyState", on_inspect=_BODIES)
def body_projected_gravity_b(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Unit vector of gravity in the frame of each chosen body. Shape is (num_envs, 3 * num_bodies)."""
    asset: Articulation = env.scene[asset_cfg.name]
    quat = columns(asset.data.body_quat_w, asset_cfg.body_ids)
    gravity = asset.data.GRAVITY_VEC_W.unsqueeze(1).expand(-1, quat.shape[1], -1)
    return math_utils.quat_apply_inverse(quat, gravity).reshape(env.num_envs, -1)


# -- joint state


@generic_io_descriptor(units="rad", observation_type="JointState", on_inspect=_JOINTS)
def joint_pos(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Positions of the chosen joints in rad or m. Shape is (num_envs, num_joints)."""
    asset: Articulation = env.scene[asset_cfg.name]
    return columns(asset.data.joint_pos, asset_cfg.joint_ids)


@generic_io_descriptor(units="rad", observation_type="JointState", on_inspect=[*_JOINTS, record_joint_pos_offsets])
def joint_pos_rel(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Positions of the chosen joints less their defaults in rad or m. Shape is (num_envs, num_joints)."""
    asset: Articulation = env.scene[asset_cfg.name]
    ids = asset_cfg.joint_ids
    return columns(asset.data.joint_pos, ids) - columns(asset.data.default_joint_pos, ids)


@generic_io_descriptor(observation_type="JointState", on_inspect=_JOINTS)
def joint_pos_limit_normalized(
    env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")
) -> torch.Tensor:
    """Positions of the chosen joints with the soft limits at -1 and 1. Shape is (num_envs, num_joints)."""
    asset: Articulation = env.scene[asset_cfg.name]
    limits = columns(asset.data.soft_joint_pos_limits, asset_cfg.joint_ids)
    position = columns(asset.data.joint_pos, asset_cfg.joint_ids)
    return math_utils.scale_transform(position, limits[..., 0], limits[..., 1])


@generic_io_descriptor(units="rad/s", observation_type="JointState", on_inspect=_JOINTS)
def joint_vel(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Velocities of the chosen joints in rad/s or m/s. Shape is (num_envs, num_joints)."""
    asset: Articulation = env.scene[asset_cfg.name]
    return columns(asset.data.joint_vel, asset_cfg.joint_ids)


@generic_io_descriptor(units="rad/s", observation_type="JointState", on_inspect=[*_JOINTS, record_joint_vel_offsets])
def joint_vel_rel(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Velocities of the chosen joints less their defaults in rad/s or m/s. Shape is (num_envs, num_joints)."""
    asset: Articulation = env.scene[asset_cfg.name]
    ids = asset_cfg.joint_ids
    return columns(asset.data.joint_vel, ids) - columns(asset.data.default_joint_vel, ids)


@generic_io_descriptor(units="N.m", observation_type="JointState", on_inspect=_JOINTS)
def joint_effort(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Efforts that act on the chosen joints in N m or N. Shape is (num_envs, num_joints)."""
    asset: Articulation = env.scene[asset_cfg.name]
    return columns(asset.data.applied_torque, asset_cfg.joint_ids)


# -- inertial measurement


@generic_io_descriptor(units="unit", axes=["W", "X", "Y", "Z"], observation_type="Sensor", on_inspect=_TENSOR)
def imu_orientation(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("imu")) -> torch.Tensor:
    """Orientation of an IMU (w, x, y, z) in the world frame. Shape is (num_envs, 4)."""
    sensor: Imu = env.scene[asset_cfg.name]
    return sensor.data.quat_w


@generic_io_descriptor(units="unit", axes=["X", "Y", "Z"], observation_type="Sensor", on_inspect=_TENSOR)
def imu_projected_gravity(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("imu")) -> torch.Tensor:
    """Unit vector of gravity in an IMU's frame. Shape is (num_envs, 3)."""
    sensor: Imu = env.scene[asset_cfg.name]
    return sensor.data.projected_gravity_b


@generic_io_descriptor(units="rad/s", axes=["X", "Y", "Z"], observation_type="Sensor", on_inspect=_TENSOR)
def imu_ang_vel(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("imu")) -> torch.Tensor:
    """Angular velocity in an IMU's frame in rad/s. Shape is (num_envs, 3)."""
    sensor: Imu = env.scene[asset_cfg.name]
    return sensor.data.ang_vel_b


@generic_io_descriptor(units="m/s^2", axes=["X", "Y", "Z"], observation_type="Sensor", on_inspect=_TENSOR)
def imu_lin_acc(env: ManagerBasedEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("imu")) -> torch.Tensor:
    """Acceleration that an IMU measures, in its frame in m/s^2. Shape is (num_envs, 3)."""
    sensor: Imu = env.scene[asset_cfg.name]
    return sensor.data.lin_acc_b


# -- actions, commands and time


@generic_io_descriptor(observation_type="Action", on_inspect=_TENSOR)
def last_action(env: ManagerBasedEnv, action_name: str | None = None) -> torch.Tensor:
    """The raw action of this step, of one term or (None) of all. Shape is (num_envs, action_dim)."""
    if action_name is None:
        return env.action_manager.action
    return env.action_manager.get_term(action_name).raw_actions


@generic_io_descriptor(observation_type="Command", on_inspect=_TENSOR)
def generated_commands(env: ManagerBasedRLEnv, command_name: str) -> torch.Tensor:
    """The command of a term of the command manager. Shape is (num_envs, command_dim)."""
    return env.command_manager.get_command(command_name)


@generic_io_descriptor(units="s", observation_type="Time", on_inspect=_TENSOR)
def current_time_s(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Time since the start of the episode in s. Shape is (num_envs, 1)."""
    return env.episode_length_buf.unsqueeze(1) * env.step_dt


@generic_io_descriptor(units="s", observation_type="Time", on_inspect=_TENSOR)
def remaining_time_s(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Time left until the episode times out in s. Shape is (num_envs, 1)."""
    return env.max_episode_length_s - env.episode_length_buf.unsqueeze(1) * env.step_dt
