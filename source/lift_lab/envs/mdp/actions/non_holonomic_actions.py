"""Action of a mobile base that is modelled with three joints: x, y and yaw."""

from __future__ import annotations

from typing import TYPE_CHECKING

import torch

from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.indexing import compact_index
from lift_lab.utils.io_descriptors import GenericActionIODescriptor

from .joint_actions import clip_limits, clipped, first_row
from .stored_action import StoredAction

if TYPE_CHECKING:
    from lift_lab.assets import Articulation
    from lift_lab.envs import ManagerBasedEnv
    from lift_lab.utils.indexing import EnvIds

    from . import actions_cfg

__all__ = [
    "NonHolonomicAction",
]


class NonHolonomicAction(StoredAction):
    """Forward speed v and yaw rate w of a base, as joint velocities ``(v cos(yaw), v sin(yaw), w)``.

    The yaw is that of the body relative to the articulation's root, since the joints move along the root's axes. Isaac
    Lab uses the yaw in the world. The two are equal while the root is not turned.
    """

    cfg: actions_cfg.NonHolonomicActionCfg
    _asset: Articulation

    def __init__(self, cfg: actions_cfg.NonHolonomicActionCfg, env: ManagerBasedEnv):
        super().__init__(cfg, env)
        joints = [
            self._only("joint", cfg.x_joint_name),
            self._only("joint", cfg.y_joint_name),
            self._only("joint", cfg.yaw_joint_name),
        ]
        self._body_idx = self._only("body", cfg.body_name)
        self._joint_ids = compact_index(joints, self._asset.num_joints, self.device)
        self._raw_actions = torch.zeros(self.num_envs, 2, device=self.device)
        self._processed_actions = torch.zeros_like(self._raw_actions)
        self._scale = torch.tensor([cfg.scale], dtype=torch.float32, device=self.device)
        self._offset = torch.tensor([cfg.offset], dtype=torch.float32, device=self.device)
        self._clip = clip_limits(cfg.clip, ["forward", "yaw"], self.num_envs, self.device)

    def _only(self, kind: str, name: str) -> int:
        find = self._asset.find_joints if kind == "joint" else self._asset.find_bodies
        ids, names = find(name)
        if len(ids) != 1:
            raise ConfigError(f"NonHolonomicAction: '{name}' must match one {kind}, it matches {names}")
        return ids[0]

    @property
    def action_dim(self) -> int:
        """2: forward speed and yaw rate."""
        return 2

    @property
    def IO_descriptor(self) -> GenericActionIODescriptor:
        """Adds ``scale``, ``offset``, ``clip``, ``body_name`` and the names of the joints."""
        descriptor = super().IO_descriptor
        descriptor.action_type, descriptor.body_name = "non holonomic actions", self._asset.body_names[self._body_idx]
        descriptor.scale, descriptor.offset = first_row(self._scale), first_row(self._offset)
        descriptor.clip = first_row(self._clip)
        cfg = self.cfg
        descriptor.x_joint_name, descriptor.y_joint_name = cfg.x_joint_name, cfg.y_joint_name
        descriptor.yaw_joint_name = cfg.yaw_joint_name
        return descriptor

    def process_actions(self, actions: torch.Tensor) -> None:
        """Scale, offset and clip the action; ``clip`` names its columns ``forward`` and ``yaw``."""
        self._raw_actions[:] = actions
        self._processed_actions = clipped(self._raw_actions * self._scale + self._offset, self._clip)

    def apply_actions(self) -> None:
        """Set the velocity targets for the current heading."""
        data = self._asset.data
        turned = math_utils.quat_mul(math_utils.quat_inv(data.root_quat_w), data.body_quat_w[:, self._body_idx])
        yaw = math_utils.euler_xyz_from_quat(turned)[2]
        forward, turn = self._processed_actions.unbind(dim=1)
        target = torch.stack((forward * torch.cos(yaw), forward * torch.sin(yaw), turn), dim=1)
        self._asset.set_joint_velocity_target(target, joint_ids=self._joint_ids)

    def reset(self, env_ids: EnvIds = None) -> None:
        """Forget the raw action of some environments."""
        self._raw_actions[slice(None) if env_ids is None else env_ids] = 0.0
