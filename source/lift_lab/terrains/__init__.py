"""Terrains: planes are simulated, generated terrains are configs only."""

from .sub_terrain_cfg import FlatPatchSamplingCfg, SubTerrainBaseCfg
from .terrain_generator_cfg import TerrainGeneratorCfg
from .terrain_importer import TerrainImporter
from .terrain_importer_cfg import TerrainImporterCfg

__all__ = [
    "FlatPatchSamplingCfg",
    "SubTerrainBaseCfg",
    "TerrainGeneratorCfg",
    "TerrainImporter",
    "TerrainImporterCfg",
]
