"""Contact points and contact forces of one environment in a browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from .contacts import Contact
from .world import WORLD

if TYPE_CHECKING:
    import viser

_WEIGHT_CM = 25.0
"""Length of an arrow for the weight of the lightest thing that moves freely."""
_FIXED_CM_PER_N = 1.0
"""Length of an arrow for each N where nothing moves freely."""
_POINT_RADIUS_M = 0.01
_LONGEST_M = 1.0
"""Forces beyond this length are drawn this long."""
_POINT_RGB, _ARROW_RGB = (230, 30, 150), (20, 140, 40)


def fitting_cm_per_n(model: mujoco.MjModel) -> float:
    """Return a length in cm for each N at which the weight of what moves freely is easy to see, two digits."""
    free = model.jnt_bodyid[model.jnt_type == mujoco.mjtJoint.mjJNT_FREE]
    weights = model.body_subtreemass[free] * np.linalg.norm(model.opt.gravity)
    weights = weights[weights > 0]
    return float(f"{_WEIGHT_CM / weights.min():.2g}") if len(weights) else _FIXED_CM_PER_N


class ContactLayer:
    """Draws a ball at each contact point, and an arrow along each contact force."""

    def __init__(self, server: viser.ViserServer, model: mujoco.MjModel):
        """Draw nothing yet.

        Args:
            server: where to draw.
            model: the compiled model, for a scale of the arrows that fits the weights in it.
        """
        self._server = server
        self._points: Any = None
        self._arrows: Any = None
        self.cm_per_n = fitting_cm_per_n(model)
        """Length of an arrow in cm for each N of force."""

    @property
    def points(self) -> Any:
        """Handle in the scene of the contact points; None while there are none."""
        return self._points

    @property
    def arrows(self) -> Any:
        """Handle in the scene of the arrows; None while there are none."""
        return self._arrows

    def update(self, contacts: list[Contact], origin_w: np.ndarray, with_points: bool, with_forces: bool) -> None:
        """Show contacts.

        Args:
            contacts: the contacts of an environment.
            origin_w: the environment's origin in m, shape (3,).
            with_points: whether to draw the points.
            with_forces: whether to draw the arrows.
        """
        places = np.array([contact.position for contact in contacts]).reshape(-1, 3) + origin_w
        forces = np.array([contact.force for contact in contacts]).reshape(-1, 3)
        with self._server.atomic():
            self._place_points(places if with_points else places[:0])
            self._place_arrows(places if with_forces else places[:0], forces)

    def hide(self) -> None:
        """Draw no contacts."""
        for handle in (self._points, self._arrows):
            if handle is not None:
                handle.remove()
        self._points = self._arrows = None

    def _place_points(self, places: np.ndarray) -> None:
        places = places.astype(np.float32)
        upright = np.tile(np.array((1, 0, 0, 0), dtype=np.float32), (len(places), 1))
        if self._points is not None and len(self._points.batched_positions) == len(places):
            self._points.batched_positions = places
            return
        if self._points is not None:
            self._points.remove()
            self._points = None
        if len(places):
            import trimesh

            ball = trimesh.creation.icosphere(subdivisions=1, radius=_POINT_RADIUS_M)
            self._points = self._server.scene.add_batched_meshes_simple(
                f"{WORLD}/contacts/points",
                np.asarray(ball.vertices, dtype=np.float32),
                np.asarray(ball.faces, dtype=np.uint32),
                upright,
                places,
                batched_colors=_POINT_RGB,
                lod="off",
                cast_shadow=False,
            )

    def _place_arrows(self, places: np.ndarray, forces: np.ndarray) -> None:
        ends = forces[: len(places)] * self.cm_per_n / 100
        length = np.linalg.norm(ends, axis=1, keepdims=True)
        seen = length[:, 0] > 1e-4
        ends = ends * np.minimum(1.0, _LONGEST_M / np.maximum(length, 1e-9))
        lines = np.stack((places, places + ends), axis=1)[seen].astype(np.float32)
        if self._arrows is not None and len(lines):
            self._arrows.points = lines
        elif self._arrows is not None:
            self._arrows.remove()
            self._arrows = None
        elif len(lines):
            self._arrows = self._server.scene.add_arrows(
                f"{WORLD}/contacts/forces",
                lines,
                _ARROW_RGB,
                shaft_radius=0.005,
                head_radius=0.012,
                head_length=0.03,
            )
