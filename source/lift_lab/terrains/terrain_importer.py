"""The terrain of a running scene."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import torch

from lift_lab.markers import VisualizationMarkers
from lift_lab.markers.config import FRAME_MARKER_CFG
from lift_lab.sim import SimulationContext
from lift_lab.utils.attributes import Entity
from lift_lab.utils.debug_vis import DebugVis
from lift_lab.utils.errors import ConfigError

if TYPE_CHECKING:
    from .terrain_importer_cfg import TerrainImporterCfg

__all__ = ["TerrainImporter"]


def grid_origins(num_envs: int, spacing: float, device: str) -> torch.Tensor:
    """Origins of environments on a square grid centred at the world's origin, shape (num_envs, 3), in m."""
    side = math.ceil(math.sqrt(num_envs))
    index = torch.arange(num_envs, device=device)
    row, col = index // side, index % side
    rows = math.ceil(num_envs / side)
    x = (row - (rows - 1) / 2) * spacing
    y = (col - (side - 1) / 2) * spacing
    return torch.stack((x, y, torch.zeros_like(x)), dim=-1).float()


class TerrainImporter(DebugVis, Entity):
    """A plane under all environments, and their origins (Isaac Lab's ``TerrainImporter``).

    A scene makes it from a field of its config and has it as ``scene.terrain`` and ``scene["terrain"]``.
    """

    cfg: TerrainImporterCfg
    """Its config, with the scene's ``num_envs`` and ``env_spacing``."""
    device: str
    """Torch device of the origins."""
    terrain_prim_paths: list[str]
    """Isaac Lab's prim path of the plane."""
    terrain_origins: torch.Tensor | None
    """Origins of the patches of a generated terrain: always None."""
    env_origins: torch.Tensor
    """Origins of the environments in the world in m, shape (num_envs, 3): the scene's own tensor."""

    def __init__(self, cfg: TerrainImporterCfg):
        """Place the environments' origins on a grid.

        Args:
            cfg: the terrain; ``num_envs`` and ``env_spacing`` are set, as a scene does.

        Raises:
            ConfigError: the terrain is no plane, the spacing is not set, or there is no simulation yet.
        """
        sim = SimulationContext.instance()
        if sim is None:
            raise ConfigError("make a SimulationContext before a TerrainImporter")
        cfg.check_type(f"'{cfg.prim_path}': ")
        if cfg.env_spacing is None:
            raise ConfigError(f"'{cfg.prim_path}': env_spacing must be set to place the environments on a grid")
        self.cfg = cfg
        self.device = sim.device
        self.terrain_prim_paths = [f"{cfg.prim_path}/terrain"]
        self.terrain_origins = None
        self.env_origins = grid_origins(cfg.num_envs, cfg.env_spacing, sim.device)

    @property
    def terrain_names(self) -> list[str]:
        """Names of the imported terrains in quotes, as Isaac Lab's."""
        return [f"'{path.rsplit('/', 1)[-1]}'" for path in self.terrain_prim_paths]

    @property
    def flat_patches(self) -> dict[str, torch.Tensor]:
        """Flat patches of a generated terrain: none."""
        return {}

    def update_env_origins(self, env_ids: torch.Tensor, move_up: torch.Tensor, move_down: torch.Tensor) -> None:
        """Move environments to harder or easier patches: without patches all stay, as in Isaac Lab.

        Args:
            env_ids: environments, shape (n,).
            move_up: which of them go to a harder patch, shape (n,).
            move_down: which go to an easier one, shape (n,).
        """

    def _set_debug_vis_impl(self, debug_vis: bool) -> None:
        if not hasattr(self, "origin_visualizer"):
            self.origin_visualizer = VisualizationMarkers(FRAME_MARKER_CFG.replace(prim_path="/Visuals/TerrainOrigin"))
        self.origin_visualizer.set_visibility(debug_vis)

    def _debug_vis_callback(self, event: Any) -> None:
        self.origin_visualizer.visualize(self.env_origins)
