"""Config of a terrain generator (data only; names of Isaac Lab's). Lengths in m."""

from __future__ import annotations

from dataclasses import MISSING
from typing import ClassVar, Literal

from lift_lab.utils import configclass
from lift_lab.utils.ranges import COUNT, FINITE, NOT_NEGATIVE, POSITIVE, SEED, SPAN, Ranges

from .sub_terrain_cfg import SubTerrainBaseCfg


@configclass
class TerrainGeneratorCfg:
    """A generated terrain: accepted as data; building a scene with one raises."""

    seed: int | None = None
    curriculum: bool = False
    size: tuple[float, float] = MISSING
    border_width: float = 0.0
    border_height: float = 1.0
    num_rows: int = 1
    num_cols: int = 1
    color_scheme: Literal["height", "random", "none"] = "none"
    horizontal_scale: float = 0.1
    vertical_scale: float = 0.005
    slope_threshold: float | None = 0.75
    sub_terrains: dict[str, SubTerrainBaseCfg] = MISSING
    difficulty_range: tuple[float, float] = (0.0, 1.0)
    use_cache: bool = False
    cache_dir: str | None = None

    _ranges: ClassVar[Ranges] = {
        "seed": SEED,
        "size horizontal_scale vertical_scale": POSITIVE,
        "border_width slope_threshold": NOT_NEGATIVE,
        "border_height": FINITE,
        "num_rows num_cols": COUNT,
        "difficulty_range": SPAN,
    }
