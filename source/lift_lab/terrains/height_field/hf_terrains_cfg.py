"""Configs of height-field terrains (data only; names of Isaac Lab's). Lengths in m."""

from __future__ import annotations

from dataclasses import MISSING
from typing import ClassVar

from lift_lab.utils import configclass
from lift_lab.utils.ranges import (
    COUNT,
    COUNT_OR_ZERO,
    FINITE,
    NOT_NEGATIVE,
    NOT_NEGATIVE_OR_INF,
    POSITIVE,
    SPAN,
    Ranges,
)

from ..sub_terrain_cfg import SubTerrainBaseCfg


@configclass
class HfTerrainBaseCfg(SubTerrainBaseCfg):
    """Base of height fields."""

    border_width: float = 0.0
    horizontal_scale: float = 0.1
    vertical_scale: float = 0.005
    slope_threshold: float | None = None

    _ranges: ClassVar[Ranges] = {
        "border_width": NOT_NEGATIVE,
        "horizontal_scale vertical_scale": POSITIVE,
        "slope_threshold": NOT_NEGATIVE_OR_INF,
    }


@configclass
class HfRandomUniformTerrainCfg(HfTerrainBaseCfg):
    """Noise."""

    noise_range: tuple[float, float] = MISSING
    noise_step: float = MISSING
    downsampled_scale: float | None = None

    _ranges: ClassVar[Ranges] = {"noise_range": SPAN, "noise_step downsampled_scale": POSITIVE}


@configclass
class HfPyramidSlopedTerrainCfg(HfTerrainBaseCfg):
    """A pyramid of slopes (rad)."""

    slope_range: tuple[float, float] = MISSING
    platform_width: float = 1.0
    inverted: bool = False

    _ranges: ClassVar[Ranges] = {"slope_range": SPAN, "platform_width": NOT_NEGATIVE}


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

    _ranges: ClassVar[Ranges] = {"step_height_range": SPAN, "step_width": POSITIVE, "platform_width": NOT_NEGATIVE}


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

    _ranges: ClassVar[Ranges] = {
        "obstacle_width_range obstacle_height_range": SPAN,
        "num_obstacles": COUNT_OR_ZERO,
        "platform_width": NOT_NEGATIVE,
    }


@configclass
class HfWaveTerrainCfg(HfTerrainBaseCfg):
    """Waves."""

    amplitude_range: tuple[float, float] = MISSING
    num_waves: int = 1

    _ranges: ClassVar[Ranges] = {"amplitude_range": SPAN, "num_waves": COUNT}


@configclass
class HfSteppingStonesTerrainCfg(HfTerrainBaseCfg):
    """Stepping stones."""

    stone_height_max: float = MISSING
    stone_width_range: tuple[float, float] = MISSING
    stone_distance_range: tuple[float, float] = MISSING
    holes_depth: float = -10.0
    platform_width: float = 1.0

    _ranges: ClassVar[Ranges] = {
        "stone_height_max platform_width": NOT_NEGATIVE,
        "stone_width_range stone_distance_range": SPAN,
        "holes_depth": FINITE,
    }
