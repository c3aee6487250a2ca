"""The bodies of every environment in a browser, each mesh sent once and then moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from .meshes import COLLIDER_COLOUR, BodyMesh, body_meshes, collision_meshes, planes
from .soft_layer import SoftLayer
from .world import WORLD

if TYPE_CHECKING:
    import viser

    from lift_lab.sim.physics.base import Physics

_COLLIDER_OPACITY = 0.55


@dataclass
class _Drawn:
    """A body's mesh in the browser, drawn once for each environment shown."""

    handle: Any
    body_id: int
    is_static: bool


class BodyLayer:
    """Draws the compiled model once for each environment, at its origin: what is seen, and what collides."""

    def __init__(self, server: viser.ViserServer, physics: Physics, env_origins_w: torch.Tensor):
        """Send all meshes that are seen, at the current poses.

        Args:
            server: where to draw.
            physics: the engine; its kinematics have to be current.
            env_origins_w: origins of the environments in m, shape (num_envs, 3).
        """
        self._server = server
        self._physics = physics
        self._all_origins_w = env_origins_w.detach().cpu().numpy().astype(np.float32)
        self._env_ids: list[int] | None = None
        self._are_visuals_shown = True
        self._are_colliders_shown = False
        self._colliders: list[_Drawn] = []
        visuals = body_meshes(physics.model)
        self._moving = [body.body_id for body in visuals if not body.is_static]
        poses = self._poses([body.body_id for body in visuals])
        self._visuals = [
            _Drawn(
                server.scene.add_batched_meshes_trimesh(
                    f"{WORLD}/bodies/{body.name}", body.mesh.to_trimesh(), *poses[body.body_id], lod="off"
                ),
                body.body_id,
                body.is_static,
            )
            for body in visuals
        ]
        self._soft = SoftLayer(server, physics, self._all_origins_w)
        for i, plane in enumerate(planes(physics.model)):
            server.scene.add_grid(
                f"{WORLD}/planes/{i}",
                width=200.0,
                height=200.0,
                infinite_grid=True,
                fade_distance=30.0,
                position=plane.position,
                wxyz=plane.quat,
            )

    @property
    def moving_bodies(self) -> dict[int, Any]:
        """Handle in the scene of the mesh of each body that moves, by the body's id in the compiled model."""
        return {drawn.body_id: drawn.handle for drawn in self._visuals if not drawn.is_static}

    @property
    def shown_envs(self) -> list[int]:
        """Environments that are drawn, in the order of the instances of each mesh."""
        return list(range(len(self._all_origins_w))) if self._env_ids is None else list(self._env_ids)

    def bounds_e(self, env_id: int) -> tuple[np.ndarray, float]:
        """Centre in m, without the environment's origin, and radius in m of what moves in an environment."""
        pos = self._physics.field("xpos")[env_id].cpu().numpy()
        pos = pos[self._moving] if self._moving else pos
        centre = (pos.min(axis=0) + pos.max(axis=0)) / 2
        return centre, max(0.3, float(np.linalg.norm(pos - centre, axis=1).max()))

    def show_envs(self, env_ids: Sequence[int] | None) -> None:
        """Draw some environments only.

        Args:
            env_ids: the environments; None for all.
        """
        self._env_ids = None if env_ids is None else list(env_ids)
        with self._server.atomic():
            self._place(self._visuals)
            self._place(self._colliders)
            self._soft.show_envs(self._env_ids)

    def show_visuals(self, shown: bool) -> None:
        """Show or hide what a camera would see of the bodies."""
        self._are_visuals_shown = shown
        for drawn in self._visuals:
            drawn.handle.visible = shown
        self._soft.show(shown)

    def show_colliders(self, shown: bool) -> None:
        """Show or hide the shapes that collide, half transparent. They are sent when they are first shown."""
        self._are_colliders_shown = shown
        if shown and not self._colliders:
            self._add_colliders(collision_meshes(self._physics.model))
        self._place(self._colliders)
        for drawn in self._colliders:
            drawn.handle.visible = shown

    def update(self) -> None:
        """Move everything to the engine's current poses."""
        with self._server.atomic():
            moving = [drawn for drawn in self._visuals if not drawn.is_static]
            if self._are_colliders_shown:
                moving += [drawn for drawn in self._colliders if not drawn.is_static]
            self._place(moving)
            self._soft.update()

    def _add_colliders(self, meshes: list[BodyMesh]) -> None:
        poses = self._poses([body.body_id for body in meshes])
        colour = np.round(255 * np.array(COLLIDER_COLOUR[:3])).astype(np.uint8)
        for body in meshes:
            handle = self._server.scene.add_batched_meshes_simple(
                f"{WORLD}/colliders/{body.name}",
                body.mesh.vertices,
                body.mesh.faces.astype(np.uint32),
                *poses[body.body_id],
                batched_colors=colour,
                opacity=_COLLIDER_OPACITY,
                flat_shading=True,
                side="double",
                lod="off",
                cast_shadow=False,
                receive_shadow=False,
            )
            self._colliders.append(_Drawn(handle, body.body_id, body.is_static))

    def _place(self, drawn: list[_Drawn]) -> None:
        """Move meshes to the current poses of their bodies, in the environments that are shown."""
        poses = self._poses([one.body_id for one in drawn])
        for one in drawn:
            one.handle.batched_wxyzs, one.handle.batched_positions = poses[one.body_id]

    def _poses(self, body_ids: list[int]) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        """Orientation and position in the world of bodies, by id, of shape (num shown, 4) and (num shown, 3)."""
        xpos, xquat, origins_w = self._physics.field("xpos"), self._physics.field("xquat"), self._all_origins_w
        if self._env_ids is not None:
            xpos, xquat, origins_w = xpos[self._env_ids], xquat[self._env_ids], origins_w[self._env_ids]
        pos = xpos[:, body_ids].transpose(0, 1).cpu().numpy() + origins_w
        quat = xquat[:, body_ids].transpose(0, 1).contiguous().cpu().numpy()
        return {body_id: (quat[i], pos[i]) for i, body_id in enumerate(body_ids)}
