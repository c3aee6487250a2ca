"""Isaac Lab's name of the object that lays a terrain: a type for annotations."""

from __future__ import annotations

from lift_lab.utils.errors import ConfigError

from .terrain_importer_cfg import TerrainImporterCfg


class TerrainImporter:
    """A type for annotations; making one raises. The scene lays its :class:`TerrainImporterCfg` itself."""

    def __init__(self, cfg: TerrainImporterCfg):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"'{cfg.prim_path}': a terrain is made as a field of the scene's config")
