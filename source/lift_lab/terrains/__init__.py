"""Terrain: a plane."""

from .terrain_importer_cfg import TerrainImporterCfg

__all__ = ["TerrainImporterCfg"]
