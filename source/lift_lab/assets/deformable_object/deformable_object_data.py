"""State of a deformable object, read from the engine on demand and kept until the engine moves on."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import torch

from lift_lab.utils import math as math_utils

from ..asset_data import AssetData, cached

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics


class DeformableObjectData(AssetData):
    """Positions and velocities of the nodes, world frame (with the environment's origin)."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_origins_w", "_qpos", "_qvel"})

    def __init__(
        self,
        physics: Physics,
        env_origins_w: torch.Tensor,
        nodes: list[int],
        qpos: slice | torch.Tensor,
        qvel: slice | torch.Tensor,
    ):
        self._physics = physics
        self._origins_w = env_origins_w
        self._qpos, self._qvel = qpos, qvel
        self._cache = {}
        model, device = physics.model, physics.device
        self.home_pos = torch.tensor(model.body_pos[nodes], dtype=torch.float32, device=device)
        """Nodes at rest in the environment's frame in m, shape (num nodes, 3)."""
        quat = torch.tensor(model.body_quat[nodes[0]], dtype=torch.float32, device=device)
        self.home_rot = math_utils.matrix_from_quat(quat)
        """Rotation from the nodes' joint axes to the world, shape (3, 3)."""
        state = torch.cat((self.home_pos, torch.zeros_like(self.home_pos)), dim=-1).repeat(physics.num_envs, 1, 1)
        state[..., :3] += env_origins_w[:, None]
        self.default_nodal_state_w = state
        """Default positions (m) and velocities (m/s), shape (num_envs, num nodes, 6)."""
        mass = float(model.body_mass[nodes].sum())
        self.default_mass = torch.full((physics.num_envs, 1), mass, device=device)
        """Mass at start in kg, shape (num_envs, 1)."""

    def _by_node(self, values: torch.Tensor) -> torch.Tensor:
        return values.view(len(values), -1, 3) @ self.home_rot.T

    @cached
    def nodal_pos_w(self) -> torch.Tensor:
        """Positions in m, shape (num_envs, num nodes, 3)."""
        offset = self._by_node(self._physics.field("qpos")[:, self._qpos].contiguous())
        return self.home_pos + offset + self._origins_w[:, None]

    @cached
    def nodal_vel_w(self) -> torch.Tensor:
        """Velocities in m/s, shape (num_envs, num nodes, 3)."""
        return self._by_node(self._physics.field("qvel")[:, self._qvel].contiguous())

    @cached
    def nodal_state_w(self) -> torch.Tensor:
        """Positions and velocities, shape (num_envs, num nodes, 6)."""
        return torch.cat((self.nodal_pos_w, self.nodal_vel_w), dim=-1)

    @cached
    def root_pos_w(self) -> torch.Tensor:
        """Mean of the nodes in m, shape (num_envs, 3)."""
        return self.nodal_pos_w.mean(dim=1)

    @cached
    def root_vel_w(self) -> torch.Tensor:
        """Mean velocity of the nodes in m/s, shape (num_envs, 3)."""
        return self.nodal_vel_w.mean(dim=1)
