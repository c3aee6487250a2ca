"""The soft bodies of every environment in a browser: one mesh of all of them, whose points move."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

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
        self._physics = physics
        self._origins_w = origins_w
        self._flexes = [SoftSurface(physics.model, flex) for flex in range(physics.model.nflex)]
        self._handles: list[Any] = []
        for surface in self._flexes:
            starts = np.arange(len(origins_w))[:, None, None] * len(surface.weights)
            self._handles.append(
                server.scene.add_mesh_simple(
                    f"/soft/{surface.name}",
                    self._points(surface),
                    (surface.faces + starts).reshape(-1, 3),
                    color=surface.rgb,
                    flat_shading=True,
                )
            )

    def update(self) -> None:
        """Move the points to the engine's current state."""
        for handle, surface in zip(self._handles, self._flexes, strict=True):
            handle.vertices = self._points(surface)

    def _points(self, surface: SoftSurface) -> np.ndarray:
        """Points of all environments in the world in m, shape (num_envs * num points, 3)."""
        nodes = self._physics.field("xpos")[:, surface.nodes].cpu().numpy()
        points = np.einsum("pn,enk->epk", surface.weights, nodes) + self._origins_w[:, None]
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
