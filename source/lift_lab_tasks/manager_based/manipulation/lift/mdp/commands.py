"""The lift task's command: a pose for the object, with success as a metric."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.envs.mdp import UniformPoseCommand, UniformPoseCommandCfg
from lift_lab.managers import SceneEntityCfg
from lift_lab.utils import configclass

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class ObjectPoseCommand(UniformPoseCommand):
    """A uniform pose command that also measures how the object follows it.

    Metrics: ``success`` (1 once the object came within :attr:`ObjectPoseCommandCfg.success_distance` in the episode),
    ``object_position_error`` (m, at the last step), beside those of the base class.
    """

    cfg: ObjectPoseCommandCfg

    def __init__(self, cfg: ObjectPoseCommandCfg, env: ManagerBasedRLEnv):
        super().__init__(cfg, env)
        self._robot_cfg = SceneEntityCfg(cfg.asset_name)
        self._object_cfg = SceneEntityCfg(cfg.object_name)
        self.metrics["success"] = torch.zeros(self.num_envs, device=self.device)
        self.metrics["object_position_error"] = torch.zeros(self.num_envs, device=self.device)

    def _update_metrics(self) -> None:
        super()._update_metrics()
        offset_w = self._env.scene[self.cfg.object_name].data.root_pos_w - self.pose_command_w[:, :3]
        distance = torch.linalg.vector_norm(offset_w, dim=1)
        self.metrics["object_position_error"] = distance
        self.metrics["success"] = torch.maximum(self.metrics["success"], (distance < self.cfg.success_distance).float())


@configclass
class ObjectPoseCommandCfg(UniformPoseCommandCfg):
    """Config of :class:`ObjectPoseCommand`."""

    class_type: type = ObjectPoseCommand
    object_name: str = "object"
    """Scene entity that is to reach the pose."""
    success_distance: float = 0.02
    """Distance in m below which the object has reached the commanded position (the study's Eq. (7))."""
