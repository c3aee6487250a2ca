"""Configs of height-field terrains (data only; names of Isaac Lab's). Lengths in m."""

from __future__ import annotations

from dataclasses import MISSING

from lift_lab.utils import configclass

from ..sub_terrain_cfg import SubTerrainBaseCfg


@configclass
class HfTerrainBaseCfg(SubTerrainBaseCfg):
    """Base of height fields."""

    border_width: float = 0.0
    horizontal_scale: float = 0.1
    vertical_scale: float = 0.005
    slope_threshold: float | None = None


@configclass
class HfRandomUniformTerrainCfg(HfTerrainBaseCfg):
    """Noise."""

    noise_range: tuple[float, float] = MISSING
    noise_step: float = MISSING
    downsampled_scale: float | None = None


@configclass
class HfPyramidSlopedTerrainCfg(HfTerrainBaseCfg):
    """A pyramid of slopes (rad)."""

    slope_range: tuple[float, float] = MISSING
    platform_width: float = 1.0
    inverted: bool = False


@configclass
class HfInvertedPyramidSlopedTerrainCfg(HfPyramidSlopedTerrainCfg):
    """A pit of slopes."""

    inverted: bool = True


@configclass
class HfPyramidStairsTerrainCfg(HfTerrainBaseCfg):
    """A pyramid of stairs."""

    step_height_range: tuple[float, float] = MISSING
    step_width: float = MISSING
    platform_width: float = 1.0
    inverted: bool = False


@configclass
class HfInvertedPyramidStairsTerrainCfg(HfPyramidStairsTerrainCfg):
    """A pit of stairs."""

    inverted: bool = True


@configclass
class HfDiscreteObstaclesTerrainCfg(HfTerrainBaseCfg):
    """Scattered blocks."""

    obstacle_height_mode: str = "choice"
    obstacle_width_range: tuple[float, float] = MISSING
    obstacle_height_range: tuple[float, float] = MISSING
    num_obstacles: int = MISSING
    platform_width: float = 1.0


@configclass
class HfWaveTerrainCfg(HfTerrainBaseCfg):
    """Waves."""

    amplitude_range: tuple[float, float] = MISSING
    num_waves: int = 1


@configclass
class HfSteppingStonesTerrainCfg(HfTerrainBaseCfg):
    """Stepping stones."""

    stone_height_max: float = MISSING
    stone_width_range: tuple[float, float] = MISSING
    stone_distance_range: tuple[float, float] = MISSING
    holes_depth: float = -10.0
    platform_width: float = 1.0
