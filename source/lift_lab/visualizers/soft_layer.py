"""The soft bodies of every environment in a browser: one mesh of all of them, whose points move."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .world import WORLD

if TYPE_CHECKING:
    import mujoco
    import viser

    from lift_lab.sim.physics.base import Physics


class SoftLayer:
    """Draws the surface of each flex of one cell (see :mod:`lift_lab.usd.deformable`)."""

    def __init__(self, server: viser.ViserServer, physics: Physics, origins_w: np.ndarray):
        """Send all surfaces, at the current state.

        Args:
            server: where to draw.
            physics: the engine; its kinematics have to be current.
            origins_w: origins of the environments in m, shape (num_envs, 3).
        """
        self._server = server
        self._physics = physics
        self._all_origins_w = origins_w
        self._env_ids: list[int] | None = None
        self._flexes = [SoftSurface(physics.model, flex) for flex in range(physics.model.nflex)]
        self._handles: list[Any] = []
        self._add()

    def show_envs(self, env_ids: Sequence[int] | None) -> None:
        """Draw some environments only; None for all."""
        self._env_ids = None if env_ids is None else list(env_ids)
        shown = all(handle.visible for handle in self._handles)
        for handle in self._handles:
            handle.remove()
        self._add()
        self.show(shown)

    def show(self, shown: bool) -> None:
        """Show or hide the surfaces."""
        for handle in self._handles:
            handle.visible = shown

    def update(self) -> None:
        """Move the points to the engine's current state."""
        for handle, surface in zip(self._handles, self._flexes, strict=True):
            handle.vertices = self._points(surface)

    def _add(self) -> None:
        """Send all surfaces, at the current state."""
        count = len(self._all_origins_w if self._env_ids is None else self._env_ids)
        self._handles = []
        for surface in self._flexes:
            starts = np.arange(count)[:, None, None] * len(surface.weights)
            self._handles.append(
                self._server.scene.add_mesh_simple(
                    f"{WORLD}/soft/{surface.name}",
                    self._points(surface),
                    (surface.faces + starts).reshape(-1, 3),
                    color=surface.rgb,
                    flat_shading=True,
                )
            )

    def _points(self, surface: SoftSurface) -> np.ndarray:
        """Points of the environments shown, in the world in m, shape (num shown * num points, 3)."""
        xpos, origins_w = self._physics.field("xpos"), self._all_origins_w
        if self._env_ids is not None:
            xpos, origins_w = xpos[self._env_ids], origins_w[self._env_ids]
        nodes = xpos[:, surface.nodes].cpu().numpy()
        points = np.einsum("pn,enk->epk", surface.weights, nodes) + origins_w[:, None]
        return points.reshape(-1, 3).astype(np.float32)


class SoftSurface:
    """Points of a flex between its eight nodes, and the triangles of its surface."""

    def __init__(self, model: mujoco.MjModel, flex: int):
        first, count = int(model.flex_nodeadr[flex]), int(model.flex_nodenum[flex])
        self.nodes = model.flex_nodebodyid[first : first + count].tolist()
        """Bodies of the nodes."""
        start, size = int(model.flex_vertadr[flex]), int(model.flex_vertnum[flex])
        share = model.flex_vert0[start : start + size, :, None]
        x, y, z = np.concatenate((1.0 - share, share), axis=2).transpose(1, 0, 2)
        self.weights = np.einsum("pi,pj,pk->pijk", x, y, z).reshape(size, -1)
        """Share of each node in each point's position, shape (num points, 8)."""
        shell = int(model.flex_shelldataadr[flex])
        self.faces = model.flex_shell[shell : shell + 3 * int(model.flex_shellnum[flex])].reshape(-1, 3).copy()
        """Points of each triangle, shape (num triangles, 3)."""
        red, green, blue = (float(c) for c in model.flex_rgba[flex][:3])
        self.rgb = (red, green, blue)
        """Colour in [0, 1]."""
        self.name = str(model.names[model.name_flexadr[flex] :].split(b"\0", 1)[0], "utf-8") or f"flex_{flex}"
        """Name of the flex."""
