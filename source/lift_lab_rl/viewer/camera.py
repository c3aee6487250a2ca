"""Cameras of the browsers, and the objects that stay in front of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch

from lift_lab.visualizers import BodyLayer, World

_DIRECTION = np.array((2.2, 1.9, 1.3))
"""From what moves in an environment to the camera, in its radii."""


def look_at(server: Any, bodies: BodyLayer, env_origins_w: torch.Tensor, env_id: int) -> None:
    """Start every page at an environment."""
    eye, target = viewpoint(bodies, env_origins_w, env_id)
    server.initial_camera.look_at = target
    server.initial_camera.position = eye


def viewpoint(bodies: BodyLayer, env_origins_w: torch.Tensor, env_id: int) -> tuple[np.ndarray, np.ndarray]:
    """Return where to stand and where to look to see what moves in an environment, in m in the world."""
    centre, radius = bodies.bounds_e(env_id)
    target = centre + env_origins_w[env_id].cpu().numpy()
    return target + radius * _DIRECTION, target


class Camera:
    """The view of all pages: at an environment, or following one of its bodies.

    To follow, the scene is shifted and the cameras stay, so that everybody can still turn and move their own.
    """

    def __init__(self, server: Any, world: World, bodies: BodyLayer, physics: Any, env_origins_w: torch.Tensor):
        """Start every page at environment 0."""
        self._server, self._world, self._bodies, self._physics = server, world, bodies, physics
        self._origins_w = env_origins_w
        self._body_id: int | None = None
        self._anchor: np.ndarray | None = None
        look_at(server, bodies, env_origins_w, 0)

    def show(self, env_id: int) -> None:
        """Move all cameras to an environment, and the scene to its place."""
        self._world.move(np.zeros(3))
        self._anchor = None
        look_at(self._server, self._bodies, self._origins_w, env_id)
        eye, target = viewpoint(self._bodies, self._origins_w, env_id)
        for client in self._server.get_clients().values():
            with client.atomic():
                client.camera.position = eye
                client.camera.look_at = target
        self.update(env_id)

    def select(self, env_id: int) -> None:
        """Move all cameras to an environment, and to its body that is followed."""
        self.show(env_id)
        self.follow(self._body_id, env_id)

    def follow(self, body_id: int | None, env_id: int) -> None:
        """Keep a body of an environment in front of the cameras, which turn to it first.

        Args:
            body_id: the body in the compiled model; None to follow nothing.
            env_id: the environment.
        """
        self._body_id = body_id
        if body_id is None:
            return
        self._anchor = target = self._position_w(body_id, env_id) + self._world.shift
        for client in self._server.get_clients().values():
            with client.atomic():
                client.camera.position = client.camera.position + target - client.camera.look_at
                client.camera.look_at = target
        initial = self._server.initial_camera
        initial.position, initial.look_at = initial.position + target - initial.look_at, target

    def update(self, env_id: int) -> None:
        """Keep the body that is followed where it was in the picture."""
        if self._body_id is None:
            return
        position = self._position_w(self._body_id, env_id)
        if self._anchor is None:
            self._anchor = position + self._world.shift
        self._world.move(self._anchor - position)

    def _position_w(self, body_id: int, env_id: int) -> np.ndarray:
        position = self._physics.field("xpos")[env_id, body_id] + self._origins_w[env_id]
        return position.cpu().numpy().astype(float)
