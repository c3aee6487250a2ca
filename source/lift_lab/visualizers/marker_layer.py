"""Markers in a browser."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import torch

from lift_lab.markers import VisualizationMarkers
from lift_lab.sim.spawners import SpawnerCfg

from .meshes import Mesh, arrow, body_meshes, merge
from .world import WORLD

if TYPE_CHECKING:
    import viser

    from lift_lab.sim import SimulationContext

_FRAME = "frame_prim.usd"
_ARROW = "arrow_x.usd"


class MarkerLayer:
    """Draws every :class:`~lift_lab.markers.VisualizationMarkers` of a simulation."""

    def __init__(self, server: viser.ViserServer, sim: SimulationContext, env_origins_w: torch.Tensor):
        """Draw nothing yet.

        Args:
            server: where to draw.
            sim: the simulation whose markers are drawn.
            env_origins_w: origins of the environments in m, shape (num_envs, 3).
        """
        self._server = server
        self._sim = sim
        self._origins_w = env_origins_w.detach().cpu().numpy()
        self._env_id: int | None = None
        self._shapes: dict[tuple[int, str], _Shape] = {}

    def show_env(self, env_id: int | None) -> None:
        """Draw the markers of one environment only, from the next :meth:`update` on; None for all."""
        self._env_id = env_id

    def update(self) -> None:
        """Draw the markers where they are now."""
        with self._server.atomic():
            for k, group in enumerate(VisualizationMarkers.of(self._sim)):
                pos = group.positions_w.cpu().numpy()
                quat, scales = group.quats_w.cpu().numpy(), group.scales.cpu().numpy()
                indices = group.marker_indices.cpu().numpy()
                for i, (name, cfg) in enumerate(group.cfg.markers.items()):
                    chosen = (indices == i) & group.is_visible() & cfg.visible
                    if self._env_id is not None:
                        chosen &= self._envs_of(pos) == self._env_id
                    if (k, name) not in self._shapes:
                        if not chosen.any():
                            continue
                        self._shapes[k, name] = _Shape(self._server, f"{WORLD}/markers/{k}/{name}", cfg)
                    self._shapes[k, name].place(pos[chosen], quat[chosen], scales[chosen])

    def _envs_of(self, pos: np.ndarray) -> np.ndarray:
        """Environment of each instance of a group, shape (n,): by number if there is one each, else the nearest."""
        if len(pos) == len(self._origins_w):
            return np.arange(len(pos))
        return np.linalg.norm(pos[:, None, :2] - self._origins_w[None, :, :2], axis=2).argmin(axis=1)


class _Shape:
    """All instances of one shape."""

    def __init__(self, server: viser.ViserServer, path: str, cfg: SpawnerCfg):
        self._server = server
        self._path = path
        file = str(getattr(cfg, "usd_path", "")).rsplit("/", 1)[-1]
        self._is_frame = file == _FRAME
        builtin = file in (_FRAME, _ARROW)
        # the spawner scales what it reads itself
        self._scale = np.asarray(getattr(cfg, "scale", None) or (1.0, 1.0, 1.0) if builtin else (1.0,) * 3)
        self._mesh: Any = None if self._is_frame else _mesh(cfg, file).to_trimesh()
        self._handle: Any = None
        self._count = 0

    def place(self, pos: np.ndarray, quat: np.ndarray, scales: np.ndarray) -> None:
        """Show instances at poses of shape (n, 3) and (n, 4) with scales of shape (n, 3)."""
        scales = (scales * self._scale).astype(np.float32)
        if len(pos) != self._count:
            if self._handle is not None:
                self._handle.remove()
            self._count = len(pos)
            self._handle = self._add(pos, quat, scales) if len(pos) else None
        elif self._handle is not None:
            self._handle.batched_positions = pos
            self._handle.batched_wxyzs = quat
            self._handle.batched_scales = scales

    def _add(self, pos: np.ndarray, quat: np.ndarray, scales: np.ndarray) -> Any:
        scene = self._server.scene
        if self._is_frame:
            return scene.add_batched_axes(
                self._path, quat, pos, batched_scales=scales, axes_length=1.0, axes_radius=0.04
            )
        return scene.add_batched_meshes_trimesh(
            self._path, self._mesh, quat, pos, batched_scales=scales, lod="off", cast_shadow=False
        )


def _mesh(cfg: SpawnerCfg, file: str) -> Mesh:
    """Triangles of a shape: an arrow, or what its spawner makes."""
    if file == _ARROW:
        colour = getattr(getattr(cfg, "visual_material", None), "diffuse_color", (0.5, 0.5, 0.5))
        return arrow((colour[0], colour[1], colour[2], 1.0))
    model = cfg.func("/marker", cfg).spec.compile()
    return merge([body.mesh for body in body_meshes(model)])
