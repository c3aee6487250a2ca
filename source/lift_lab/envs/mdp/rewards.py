"""Reward terms, with Isaac Lab's names: functions ``(env, **params) -> tensor`` of shape (num_envs,).

The reward manager multiplies each value by its weight and the environment's time step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import torch

from lift_lab.managers import ManagerTermBase, SceneEntityCfg
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.indexing import columns
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, POSITIVE

if TYPE_CHECKING:
    from lift_lab.assets import Articulation, RigidObject
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.managers import RewardTermCfg
    from lift_lab.sensors import ContactSensor

__all__ = [
    "action_l2",
    "action_rate_l2",
    "ang_vel_xy_l2",
    "applied_torque_limits",
    "base_height_l2",
    "body_lin_acc_l2",
    "contact_forces",
    "desired_contacts",
    "flat_orientation_l2",
    "is_alive",
    "is_terminated",
    "is_terminated_term",
    "joint_acc_l2",
    "joint_deviation_l1",
    "joint_pos_limits",
    "joint_torques_l2",
    "joint_vel_l1",
    "joint_vel_l2",
    "joint_vel_limits",
    "lin_vel_z_l2",
    "track_ang_vel_z_exp",
    "track_lin_vel_xy_exp",
    "undesired_contacts",
]

# -- general


def is_alive(env: ManagerBasedRLEnv) -> torch.Tensor:
    """1 unless the episode has just terminated."""
    return (~env.termination_manager.terminated).float()


def is_terminated(env: ManagerBasedRLEnv) -> torch.Tensor:
    """1 if the episode has just ended for another reason than time."""
    return env.termination_manager.terminated.float()


class is_terminated_term(ManagerTermBase):
    """Number of the named termination terms that ended the episode; 0 when time ended it.

    Params:
        term_keys: names or patterns of termination terms. The default is all.
    """

    def __init__(self, cfg: RewardTermCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._term_names = env.termination_manager.find_terms(cfg.params.get("term_keys", ".*"))

    def __call__(self, env: ManagerBasedRLEnv, term_keys: str | list[str] = ".*") -> torch.Tensor:
        count = torch.zeros(env.num_envs, device=env.device)
        for name in self._term_names:
            count += env.termination_manager.get_term(name)
        return count * ~env.termination_manager.time_outs


# -- root


def lin_vel_z_l2(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Squared vertical velocity of the root, in the root frame."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_lin_vel_b[:, 2].square()


def ang_vel_xy_l2(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Squared roll and pitch rate of the root, in the root frame."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.root_ang_vel_b[:, :2].square().sum(dim=1)


def flat_orientation_l2(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Squared horizontal part of gravity in the root frame: 0 when upright, 1 on the side."""
    asset: RigidObject = env.scene[asset_cfg.name]
    return asset.data.projected_gravity_b[:, :2].square().sum(dim=1)


def base_height_l2(
    env: ManagerBasedRLEnv,
    target_height: Annotated[float, FINITE],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
    sensor_cfg: SceneEntityCfg | None = None,
) -> torch.Tensor:
    """Squared difference of the root's height to ``target_height`` (m, world frame).

    Raises:
        ConfigError: a ``sensor_cfg``; Isaac Lab's is a ray caster that measures the ground's height.
    """
    if sensor_cfg is not None:
        raise ConfigError("mdp.base_height_l2: sensor_cfg needs a ray caster, which is not simulated; leave it None")
    asset: RigidObject = env.scene[asset_cfg.name]
    return (asset.data.root_pos_w[:, 2] - target_height).square()


def body_lin_acc_l2(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Sum over the chosen bodies of the magnitude of their linear acceleration (not squared, as in Isaac Lab)."""
    asset: Articulation = env.scene[asset_cfg.name]
    return columns(asset.data.body_lin_acc_w, asset_cfg.body_ids).norm(dim=-1).sum(dim=1)


# -- joints


def joint_torques_l2(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Squared efforts of the chosen joints."""
    asset: Articulation = env.scene[asset_cfg.name]
    return columns(asset.data.applied_torque, asset_cfg.joint_ids).square().sum(dim=1)


def joint_vel_l1(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg) -> torch.Tensor:
    """Absolute velocities of the chosen joints."""
    asset: Articulation = env.scene[asset_cfg.name]
    return columns(asset.data.joint_vel, asset_cfg.joint_ids).abs().sum(dim=1)


def joint_vel_l2(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Squared velocities of the chosen joints."""
    asset: Articulation = env.scene[asset_cfg.name]
    return columns(asset.data.joint_vel, asset_cfg.joint_ids).square().sum(dim=1)


def joint_acc_l2(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Squared accelerations of the chosen joints."""
    asset: Articulation = env.scene[asset_cfg.name]
    return columns(asset.data.joint_acc, asset_cfg.joint_ids).square().sum(dim=1)


def joint_deviation_l1(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Absolute differences of the chosen joints' positions to their defaults."""
    asset: Articulation = env.scene[asset_cfg.name]
    ids = asset_cfg.joint_ids
    difference = columns(asset.data.joint_pos, ids) - columns(asset.data.default_joint_pos, ids)
    return difference.abs().sum(dim=1)


def joint_pos_limits(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Sum of the distances of the chosen joints beyond their soft position limits."""
    asset: Articulation = env.scene[asset_cfg.name]
    position = columns(asset.data.joint_pos, asset_cfg.joint_ids)
    limits = columns(asset.data.soft_joint_pos_limits, asset_cfg.joint_ids)
    below = (limits[..., 0] - position).clamp(min=0.0)
    above = (position - limits[..., 1]).clamp(min=0.0)
    return (below + above).sum(dim=1)


def joint_vel_limits(
    env: ManagerBasedRLEnv,
    soft_ratio: Annotated[float, NOT_NEGATIVE],
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> torch.Tensor:
    """Sum of the excess speeds of the chosen joints over ``soft_ratio`` of their velocity limits, at most 1 for each
    joint."""
    asset: Articulation = env.scene[asset_cfg.name]
    speed = columns(asset.data.joint_vel, asset_cfg.joint_ids).abs()
    limits = columns(asset.data.soft_joint_vel_limits, asset_cfg.joint_ids)
    return (speed - limits * soft_ratio).clamp(min=0.0, max=1.0).sum(dim=1)


# -- actions


def applied_torque_limits(env: ManagerBasedRLEnv, asset_cfg: SceneEntityCfg = SceneEntityCfg("robot")) -> torch.Tensor:
    """Sum of the clipped parts of the efforts of the chosen joints."""
    asset: Articulation = env.scene[asset_cfg.name]
    ids = asset_cfg.joint_ids
    clipped = columns(asset.data.applied_torque, ids) - columns(asset.data.computed_torque, ids)
    return clipped.abs().sum(dim=1)


def action_rate_l2(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Squared change of the raw action since the step before."""
    return (env.action_manager.action - env.action_manager.prev_action).square().sum(dim=1)


def action_l2(env: ManagerBasedRLEnv) -> torch.Tensor:
    """Squared raw action."""
    return env.action_manager.action.square().sum(dim=1)


# -- contact


def _peak_contact_force(env: ManagerBasedRLEnv, sensor_cfg: SceneEntityCfg) -> torch.Tensor:
    """Largest force within the sensor's history for each chosen body in N. Shape is (num_envs, num_bodies)."""
    sensor: ContactSensor = env.scene.sensors[sensor_cfg.name]
    return columns(sensor.data.net_forces_w_history.norm(dim=-1).amax(dim=1), sensor_cfg.body_ids)


def undesired_contacts(
    env: ManagerBasedRLEnv, threshold: Annotated[float, FINITE], sensor_cfg: SceneEntityCfg
) -> torch.Tensor:
    """Number of chosen bodies with more than ``threshold`` (N) of contact force."""
    return (_peak_contact_force(env, sensor_cfg) > threshold).sum(dim=1)


def desired_contacts(
    env: ManagerBasedRLEnv, sensor_cfg: SceneEntityCfg, threshold: Annotated[float, FINITE] = 1.0
) -> torch.Tensor:
    """1 if none of the chosen bodies has more than ``threshold`` (N) of contact force."""
    return (_peak_contact_force(env, sensor_cfg) <= threshold).all(dim=1).float()


def contact_forces(
    env: ManagerBasedRLEnv, threshold: Annotated[float, FINITE], sensor_cfg: SceneEntityCfg
) -> torch.Tensor:
    """Contact force above ``threshold`` (N), summed over the chosen bodies."""
    return (_peak_contact_force(env, sensor_cfg) - threshold).clamp(min=0.0).sum(dim=1)


# -- tracking of velocity commands


def track_lin_vel_xy_exp(
    env: ManagerBasedRLEnv,
    std: Annotated[float, POSITIVE],
    command_name: str,
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> torch.Tensor:
    """``exp(-e^2 / std^2)`` of the error to the commanded horizontal velocity in the root frame."""
    asset: RigidObject = env.scene[asset_cfg.name]
    command = env.command_manager.get_command(command_name)
    error = (command[:, :2] - asset.data.root_lin_vel_b[:, :2]).square().sum(dim=1)
    return torch.exp(-error / std**2)


def track_ang_vel_z_exp(
    env: ManagerBasedRLEnv,
    std: Annotated[float, POSITIVE],
    command_name: str,
    asset_cfg: SceneEntityCfg = SceneEntityCfg("robot"),
) -> torch.Tensor:
    """``exp(-e^2 / std^2)`` of the error to the commanded yaw rate in the root frame."""
    asset: RigidObject = env.scene[asset_cfg.name]
    command = env.command_manager.get_command(command_name)
    error = (command[:, 2] - asset.data.root_ang_vel_b[:, 2]).square()
    return torch.exp(-error / std**2)
