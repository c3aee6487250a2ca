"""Config of a group of markers (Isaac Lab's)."""

from __future__ import annotations

from dataclasses import MISSING

from lift_lab.sim.spawners.spawner_cfg import SpawnerCfg
from lift_lab.utils import configclass


@configclass
class VisualizationMarkersCfg:
    """Shapes drawn over a scene, each a spawner by name."""

    prim_path: str = MISSING
    """Isaac Lab's prim path of the markers. A label here."""
    markers: dict[str, SpawnerCfg] = MISSING
    """Marker name -> its shape."""
