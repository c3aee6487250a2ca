"""Pull a body with the mouse: a damped spring between the point that was grabbed and the pointer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.math import quat_apply, quat_apply_inverse

MODIFIER = "cmd/ctrl"
"""Key that is held while the left button drags a body. Without it the mouse turns the camera."""
_FREQUENCY = 15.0
"""Natural frequency of the spring in rad/s. A free body hangs 9.81 / 15**2 = 0.044 m below the pointer, or more if it
is not grabbed at its centre."""
_MOST_PER_STEP = 0.4
"""Largest natural frequency times the time between two updates of the force: more would be unstable."""


@dataclass
class Pull:
    """Pull of the mouse on a body."""

    env_id: int
    body_id: int
    """Body of the compiled model."""
    point_b: torch.Tensor
    """Grabbed point in the body's frame in m, shape (3,)."""
    target_w: torch.Tensor
    """Position of the pointer in the world in m, shape (3,)."""
    last_w: torch.Tensor | None = None
    """Position of the grabbed point one environment step ago; None at first and after a reset."""


class BodyPuller:
    """Applies the force of the mouse to one body of one environment during each environment step.

    The force is added to the body's external wrench before the step, and taken off after it. Nothing else of the task
    changes.
    """

    def __init__(self, env: Any):
        """Pull nothing yet.

        Args:
            env: the environment without wrappers.
        """
        self._env = env
        self._model = env.sim.physics.model
        assets = [*env.scene.articulations.values(), *env.scene.rigid_objects.values()]
        places = [(asset, i, body) for asset in assets for i, body in enumerate(asset.engine_body_ids)]
        # the inverse weight is how far a unit of force accelerates the body; zero if none can move it
        inverse_masses = self._model.body_invweight0[:, 0]
        self._places = {body: (asset, i) for asset, i, body in places if inverse_masses[body] > 0}
        self._frequency = min(_FREQUENCY, _MOST_PER_STEP / env.step_dt)
        self._pull: Pull | None = None
        self._before: torch.Tensor | None = None
        self._set: torch.Tensor | None = None
        self.force = torch.zeros(3)
        """Force of the last step in N in the world frame, shape (3,)."""

    @property
    def body_ids(self) -> list[int]:
        """Bodies of the compiled model that can be pulled."""
        return list(self._places)

    @property
    def pull(self) -> Pull | None:
        """Current pull; None if nothing is pulled."""
        return self._pull

    def grab(self, env_id: int, body_id: int, point_w: np.ndarray) -> None:
        """Begin to pull a body at a point in m in the world, shape (3,).

        Raises:
            ConfigError: the point is not finite.
        """
        pos, quat = self._pose(env_id, body_id)
        point = _point(point_w, pos)
        self._pull = Pull(env_id, body_id, quat_apply_inverse(quat, point - pos), point)

    def move(self, target_w: np.ndarray) -> None:
        """Pull towards another point in m in the world, shape (3,).

        Raises:
            ConfigError: the point is not finite.
        """
        if self._pull is not None:
            self._pull.target_w = _point(target_w, self._pull.target_w)

    def let_go(self) -> None:
        """Pull nothing any more."""
        self._pull = None
        self.force = torch.zeros(3)

    def forget_motion(self) -> None:
        """Take no velocity from the last step: the body was put elsewhere."""
        if self._pull is not None:
            self._pull.last_w = None

    def before_step(self) -> None:
        """Add the force to the body's external wrench."""
        pull = self._pull
        if pull is None:
            return
        pos, quat = self._pose(pull.env_id, pull.body_id)
        point = pos + quat_apply(quat, pull.point_b)
        velocity = torch.zeros_like(point) if pull.last_w is None else (point - pull.last_w) / self._env.step_dt
        pull.last_w = point
        mass = self._mass_at(pull)
        stiffness, damping = mass * self._frequency**2, 2 * mass * self._frequency
        self.force = stiffness * (pull.target_w - point) - damping * velocity
        self._before = before = self._wrench_b().clone()
        self._write(self.force, torch.zeros_like(self.force), point)
        ours = self._wrench_b() + before
        self._write(ours[:3], ours[3:])
        self._set = self._wrench_b().clone()

    def after_step(self, dones: torch.Tensor) -> None:
        """Take the force off again.

        Args:
            dones: environments that were reset in the step, shape (num_envs,).
        """
        pull, before, ours = self._pull, self._before, self._set
        self._before = self._set = None
        if pull is None or before is None or ours is None:
            return
        if torch.equal(self._wrench_b(), ours):  # else a reset or an event has set another
            self._write(before[:3], before[3:])
        if dones[pull.env_id]:
            self.forget_motion()

    def _mass_at(self, pull: Pull) -> float:
        """Force in N at the grabbed point for each m/s^2 there, at least: a lever makes it less."""
        lever = pull.point_b.cpu().numpy() - self._model.body_ipos[pull.body_id]
        linear, angular = self._model.body_invweight0[pull.body_id]
        return float(1.0 / (linear + angular * (lever @ lever)))

    def _wrench_b(self) -> torch.Tensor:
        """External wrench of the body that is pulled, shape (6,)."""
        assert self._pull is not None
        asset, index = self._places[self._pull.body_id]
        return asset.external_wrench_b[self._pull.env_id, index]

    def _write(self, force: torch.Tensor, torque: torch.Tensor, point_w: torch.Tensor | None = None) -> None:
        """Set the external wrench of the body that is pulled: in its frame, or at a point in the world frame."""
        assert self._pull is not None
        asset, index = self._places[self._pull.body_id]
        asset.set_external_force_and_torque(
            force.reshape(1, 1, 3),
            torque.reshape(1, 1, 3),
            positions=None if point_w is None else point_w.reshape(1, 1, 3),
            body_ids=[index],
            env_ids=torch.tensor([self._pull.env_id], device=force.device),
            is_global=point_w is not None,
        )

    def _pose(self, env_id: int, body_id: int) -> tuple[torch.Tensor, torch.Tensor]:
        """Position in m in the world and orientation (w, x, y, z) of a body's frame, shape (3,) and (4,)."""
        asset, index = self._places[body_id]
        return asset.data.body_link_pos_w[env_id, index], asset.data.body_link_quat_w[env_id, index]


def _point(point: np.ndarray, like: torch.Tensor) -> torch.Tensor:
    """A point as a tensor of the type of another."""
    if np.shape(point) != (3,) or not np.isfinite(point).all():
        raise ConfigError(f"cannot pull at {point}: it is no point")
    return torch.tensor(point, dtype=like.dtype, device=like.device)
