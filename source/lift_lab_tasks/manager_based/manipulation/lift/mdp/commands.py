"""The lift task's command: a pose for the object, with success and smoothness as metrics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import torch

from lift_lab.envs.mdp import UniformPoseCommand, UniformPoseCommandCfg
from lift_lab.envs.mdp._tensors import block, compact_index
from lift_lab.managers import SceneEntityCfg
from lift_lab.utils import configclass

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class ObjectPoseCommand(UniformPoseCommand):
    """A uniform pose command that also measures how the object follows it, and how smoothly the robot moves.

    Metrics beside those of the base class, each of one episode:

    - ``success``: 1 once the object came within :attr:`ObjectPoseCommandCfg.success_distance`.
    - ``time_to_success_s``: when it first did, in s. Only episodes that succeeded count; absent if none did.
    - ``object_position_error``: distance in m at the last step.
    - ``first_pick_drop``: 1 if the object was held up and then fell back
      (:attr:`ObjectPoseCommandCfg.pick_heights_m`).
    - ``squared_action_change``: mean over the steps of ``|a_t - a_(t-1)|^2``, raw actions (the study's Eq. (5)).
    - ``squared_joint_acceleration``: mean over steps and joints of the squared acceleration in (rad/s^2)^2, from the
      joint velocities of one environment step to the next.
    """

    cfg: ObjectPoseCommandCfg

    def __init__(self, cfg: ObjectPoseCommandCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._robot_cfg = SceneEntityCfg(cfg.asset_name)
        self._object_cfg = SceneEntityCfg(cfg.object_name)
        joint_ids, _ = self.robot.find_joints(cfg.smoothness_joint_names)
        self._joint_ids = compact_index(joint_ids, self.robot.num_joints, self.device)
        zeros = torch.zeros(self.num_envs, device=self.device)
        for name in ("success", "object_position_error", "first_pick_drop"):
            self.metrics[name] = zeros.clone()
        self.metrics["squared_action_change"] = zeros.clone()
        self.metrics["squared_joint_acceleration"] = zeros.clone()
        self._success_s = zeros.clone()
        self._held = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)
        self._steps = zeros.clone()
        self._joint_vel = torch.zeros(self.num_envs, len(joint_ids), device=self.device)

    def reset(self, env_ids: Any = None) -> dict[str, torch.Tensor]:
        """Start an episode; returns the mean of each metric over the episodes that end."""
        ids = slice(None) if env_ids is None else env_ids
        succeeded = self.metrics["success"][ids] > 0
        times_s = self._success_s[ids][succeeded]
        extras = super().reset(env_ids)
        if len(times_s):
            extras["time_to_success_s"] = times_s.mean()
        self._success_s[ids] = 0.0
        self._steps[ids] = 0.0
        self._held[ids] = False
        self._joint_vel[ids] = block(self.robot.data.joint_vel, ids, self._joint_ids)
        return extras

    def _update_metrics(self) -> None:
        super()._update_metrics()
        metrics = self.metrics
        pos_w = self._env.scene[self.cfg.object_name].data.root_pos_w
        distance = torch.linalg.vector_norm(pos_w - self.pose_command_w[:, :3], dim=1)
        metrics["object_position_error"] = distance
        reached = distance < self.cfg.success_distance
        first = reached & (metrics["success"] == 0)
        self._success_s = torch.where(first, self._env.episode_length_buf * self._env.step_dt, self._success_s)
        metrics["success"] = torch.where(reached, 1.0, metrics["success"])
        low_m, high_m = self.cfg.pick_heights_m
        height_m = pos_w[:, 2]
        fell = self._held & (height_m < low_m)
        metrics["first_pick_drop"] = torch.where(fell, 1.0, metrics["first_pick_drop"])
        self._held = (self._held > fell) | (height_m > high_m)  # of booleans, > is "and not"
        self._update_smoothness()

    def _update_smoothness(self) -> None:
        """Running means over the steps of the episode; the call in the step that resets sees none yet."""
        manager, joint_vel = self._env.action_manager, block(self.robot.data.joint_vel, None, self._joint_ids)
        action_change = (manager.action - manager.prev_action).square().sum(dim=1)
        acceleration = ((joint_vel - self._joint_vel) / self._env.step_dt).square().mean(dim=1)
        self._joint_vel = joint_vel
        stepped = (self._env.episode_length_buf > 0).float()
        self._steps = self._steps + stepped
        share = stepped / self._steps.clamp(min=1.0)
        for name, value in (("squared_action_change", action_change), ("squared_joint_acceleration", acceleration)):
            self.metrics[name] = self.metrics[name] + share * (value - self.metrics[name])


@configclass
class ObjectPoseCommandCfg(UniformPoseCommandCfg):
    """Config of :class:`ObjectPoseCommand`."""

    class_type: type = ObjectPoseCommand
    object_name: str = "object"
    """Scene entity that is to reach the pose."""
    success_distance: float = 0.02
    """Distance in m below which the object has reached the commanded position (the study's Eq. (7))."""
    pick_heights_m: tuple[float, float] = (0.03, 0.06)
    """An object above the second height (m, world) is held; below the first one after that, it was dropped."""
    smoothness_joint_names: list[str] = [".*"]
    """Joints whose accelerations are measured."""
