"""Configs of terrains made of meshes (data only; names of Isaac Lab's). Lengths in m."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING
from typing import Any, Literal

from lift_lab.utils import configclass

from ..sub_terrain_cfg import SubTerrainBaseCfg


@configclass
class MeshPlaneTerrainCfg(SubTerrainBaseCfg):
    """A plane."""


@configclass
class MeshPyramidStairsTerrainCfg(SubTerrainBaseCfg):
    """A pyramid of stairs."""

    border_width: float = 0.0
    step_height_range: tuple[float, float] = MISSING
    step_width: float = MISSING
    platform_width: float = 1.0
    holes: bool = False


@configclass
class MeshInvertedPyramidStairsTerrainCfg(MeshPyramidStairsTerrainCfg):
    """A pit of stairs."""


@configclass
class MeshRandomGridTerrainCfg(SubTerrainBaseCfg):
    """A grid of blocks."""

    grid_width: float = MISSING
    grid_height_range: tuple[float, float] = MISSING
    platform_width: float = 1.0
    holes: bool = False


@configclass
class MeshRailsTerrainCfg(SubTerrainBaseCfg):
    """Rails."""

    rail_thickness_range: tuple[float, float] = MISSING
    rail_height_range: tuple[float, float] = MISSING
    platform_width: float = 1.0


@configclass
class MeshPitTerrainCfg(SubTerrainBaseCfg):
    """A pit."""

    pit_depth_range: tuple[float, float] = MISSING
    platform_width: float = 1.0
    double_pit: bool = False


@configclass
class MeshBoxTerrainCfg(SubTerrainBaseCfg):
    """A box."""

    box_height_range: tuple[float, float] = MISSING
    platform_width: float = 1.0
    double_box: bool = False


@configclass
class MeshGapTerrainCfg(SubTerrainBaseCfg):
    """A gap around a platform."""

    gap_width_range: tuple[float, float] = MISSING
    platform_width: float = 1.0


@configclass
class MeshFloatingRingTerrainCfg(SubTerrainBaseCfg):
    """A floating ring."""

    ring_width_range: tuple[float, float] = MISSING
    ring_height_range: tuple[float, float] = MISSING
    ring_thickness: float = MISSING
    platform_width: float = 1.0


@configclass
class MeshStarTerrainCfg(SubTerrainBaseCfg):
    """A star of bars."""

    num_bars: int = MISSING
    bar_width_range: tuple[float, float] = MISSING
    bar_height_range: tuple[float, float] = MISSING
    platform_width: float = 1.0


@configclass
class MeshRepeatedObjectsTerrainCfg(SubTerrainBaseCfg):
    """Base of terrains strewn with objects."""

    @configclass
    class ObjectCfg:
        """How many objects, how high."""

        num_objects: int = MISSING
        height: float = MISSING

    object_type: Literal["cylinder", "box", "cone"] | Callable[..., Any] = MISSING
    object_params_start: ObjectCfg = MISSING
    object_params_end: ObjectCfg = MISSING
    max_height_noise: float | None = None
    abs_height_noise: tuple[float, float] = (0.0, 0.0)
    rel_height_noise: tuple[float, float] = (1.0, 1.0)
    platform_width: float = 1.0
    platform_height: float = -1.0


@configclass
class MeshRepeatedPyramidsTerrainCfg(MeshRepeatedObjectsTerrainCfg):
    """Strewn with pyramids."""

    @configclass
    class ObjectCfg(MeshRepeatedObjectsTerrainCfg.ObjectCfg):
        """Size and tilt of the objects."""

        radius: float = MISSING
        max_yx_angle: float = 0.0
        degrees: bool = True

    object_type: Literal["cylinder", "box", "cone"] | Callable[..., Any] = "cone"
    object_params_start: ObjectCfg = MISSING
    object_params_end: ObjectCfg = MISSING


@configclass
class MeshRepeatedBoxesTerrainCfg(MeshRepeatedObjectsTerrainCfg):
    """Strewn with boxes."""

    @configclass
    class ObjectCfg(MeshRepeatedObjectsTerrainCfg.ObjectCfg):
        """Size and tilt of the objects."""

        size: tuple[float, float] = MISSING
        max_yx_angle: float = 0.0
        degrees: bool = True

    object_type: Literal["cylinder", "box", "cone"] | Callable[..., Any] = "box"
    object_params_start: ObjectCfg = MISSING
    object_params_end: ObjectCfg = MISSING


@configclass
class MeshRepeatedCylindersTerrainCfg(MeshRepeatedObjectsTerrainCfg):
    """Strewn with cylinders."""

    @configclass
    class ObjectCfg(MeshRepeatedObjectsTerrainCfg.ObjectCfg):
        """Size and tilt of the objects."""

        radius: float = MISSING
        max_yx_angle: float = 0.0
        degrees: bool = True

    object_type: Literal["cylinder", "box", "cone"] | Callable[..., Any] = "cylinder"
    object_params_start: ObjectCfg = MISSING
    object_params_end: ObjectCfg = MISSING
