"""The axes of bodies and sites of one environment in a browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from .world import WORLD

if TYPE_CHECKING:
    import viser

BODY_AXES_M = 0.1
"""Length of a body's axes in m."""
SITE_AXES_M = 0.05
"""Length of a site's axes in m."""


class FrameLayer:
    """Draws the frame of each moving body, and shorter and thicker that of each site: x red, y green, z blue."""

    def __init__(self, server: viser.ViserServer, model: mujoco.MjModel):
        """Draw nothing yet.

        Args:
            server: where to draw.
            model: the compiled model.
        """
        self._server = server
        self._body_ids = [body for body in range(1, model.nbody) if model.body_weldid[body] != 0]
        self._num_sites = model.nsite
        self._bodies: Any = None
        self._sites: Any = None

    @property
    def body_frames(self) -> Any:
        """Handle in the scene of the bodies' axes; None before they are first shown."""
        return self._bodies

    def hide(self) -> None:
        """Hide all axes."""
        for handle in (self._bodies, self._sites):
            if handle is not None:
                handle.visible = False

    def update(self, data: mujoco.MjData, origin_w: np.ndarray) -> None:
        """Show the axes as they are in the state of an environment.

        Args:
            data: the environment's state, with its kinematics computed.
            origin_w: the environment's origin in m, shape (3,).
        """
        with self._server.atomic():
            pos, quat = data.xpos[self._body_ids] + origin_w, data.xquat[self._body_ids]
            self._bodies = self._place(self._bodies, "bodies", pos, quat, BODY_AXES_M, 0.03)
            quat = np.zeros((self._num_sites, 4))
            for site in range(self._num_sites):
                mujoco.mju_mat2Quat(quat[site], data.site_xmat[site])
            self._sites = self._place(self._sites, "sites", data.site_xpos + origin_w, quat, SITE_AXES_M, 0.08)

    def _place(self, handle: Any, name: str, pos: np.ndarray, quat: np.ndarray, length: float, thickness: float) -> Any:
        if not len(pos):
            return None
        pos, quat = pos.astype(np.float32), quat.astype(np.float32)
        if handle is None:
            return self._server.scene.add_batched_axes(
                f"{WORLD}/frames/{name}", quat, pos, axes_length=length, axes_radius=thickness * length
            )
        handle.visible = True
        handle.batched_positions, handle.batched_wxyzs = pos, quat
        return handle
