"""The bodies of every environment in a browser, each mesh sent once and then moved."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .meshes import body_meshes, planes
from .soft_layer import SoftLayer

if TYPE_CHECKING:
    import viser

    from lift_lab.sim.physics.base import Physics


class BodyLayer:
    """Draws the compiled model once for each environment, at its origin."""

    def __init__(self, server: viser.ViserServer, physics: Physics, env_origins_w: torch.Tensor):
        """Send all meshes, at the current poses.

        Args:
            server: where to draw.
            physics: the engine; its kinematics have to be current.
            env_origins_w: origins of the environments in m, shape (num_envs, 3).
        """
        self._server = server
        self._physics = physics
        self._origins_w = env_origins_w.detach().cpu().numpy().astype(np.float32)
        self._handles: list[Any] = []
        self._body_ids: list[int] = []
        bodies = body_meshes(physics.model)
        poses = self._poses([body.body_id for body in bodies])
        for body, (position, quat) in zip(bodies, poses, strict=True):
            handle = server.scene.add_batched_meshes_trimesh(
                f"/bodies/{body.name}", body.mesh.to_trimesh(), quat, position, lod="off"
            )
            if not body.is_static:
                self._handles.append(handle)
                self._body_ids.append(body.body_id)
        self._soft = SoftLayer(server, physics, self._origins_w)
        for i, plane in enumerate(planes(physics.model)):
            server.scene.add_grid(
                f"/planes/{i}",
                width=200.0,
                height=200.0,
                infinite_grid=True,
                fade_distance=30.0,
                position=plane.position,
                wxyz=plane.quat,
            )

    @property
    def body_ids(self) -> list[int]:
        """Bodies that move."""
        return list(self._body_ids)

    def bounds_e(self, env_id: int) -> tuple[np.ndarray, float]:
        """Centre in m, without the environment's origin, and radius in m of what moves in an environment."""
        pos = self._physics.field("xpos")[env_id].cpu().numpy()
        pos = pos[self._body_ids] if self._body_ids else pos
        centre = (pos.min(axis=0) + pos.max(axis=0)) / 2
        return centre, max(0.3, float(np.linalg.norm(pos - centre, axis=1).max()))

    def update(self) -> None:
        """Move everything to the engine's current poses."""
        with self._server.atomic():
            for handle, (position, quat) in zip(self._handles, self._poses(self._body_ids), strict=True):
                handle.batched_positions = position
                handle.batched_wxyzs = quat
            self._soft.update()

    def _poses(self, body_ids: list[int]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Positions in the world and orientations of some bodies, each of shape (num_envs, 3) and (num_envs, 4)."""
        pos = self._physics.field("xpos")[:, body_ids].transpose(0, 1).cpu().numpy() + self._origins_w
        quat = self._physics.field("xquat")[:, body_ids].transpose(0, 1).contiguous().cpu().numpy()
        return list(zip(pos, quat, strict=True))
