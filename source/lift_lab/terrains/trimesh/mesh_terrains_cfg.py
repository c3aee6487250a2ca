"""Configs of terrains made of meshes (data only; names of Isaac Lab's). Lengths in m."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING
from typing import Any, ClassVar, Literal

from lift_lab.utils import configclass
from lift_lab.utils.ranges import COUNT, FINITE, NOT_NEGATIVE, POSITIVE, SPAN, Ranges

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

    _ranges: ClassVar[Ranges] = {
        "border_width platform_width": NOT_NEGATIVE,
        "step_height_range": SPAN,
        "step_width": POSITIVE,
    }


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

    _ranges: ClassVar[Ranges] = {"grid_width": POSITIVE, "grid_height_range": SPAN, "platform_width": NOT_NEGATIVE}


@configclass
class MeshRailsTerrainCfg(SubTerrainBaseCfg):
    """Rails."""

    rail_thickness_range: tuple[float, float] = MISSING
    rail_height_range: tuple[float, float] = MISSING
    platform_width: float = 1.0

    _ranges: ClassVar[Ranges] = {"rail_thickness_range rail_height_range": SPAN, "platform_width": NOT_NEGATIVE}


@configclass
class MeshPitTerrainCfg(SubTerrainBaseCfg):
    """A pit."""

    pit_depth_range: tuple[float, float] = MISSING
    platform_width: float = 1.0
    double_pit: bool = False

    _ranges: ClassVar[Ranges] = {"pit_depth_range": SPAN, "platform_width": NOT_NEGATIVE}


@configclass
class MeshBoxTerrainCfg(SubTerrainBaseCfg):
    """A box."""

    box_height_range: tuple[float, float] = MISSING
    platform_width: float = 1.0
    double_box: bool = False

    _ranges: ClassVar[Ranges] = {"box_height_range": SPAN, "platform_width": NOT_NEGATIVE}


@configclass
class MeshGapTerrainCfg(SubTerrainBaseCfg):
    """A gap around a platform."""

    gap_width_range: tuple[float, float] = MISSING
    platform_width: float = 1.0

    _ranges: ClassVar[Ranges] = {"gap_width_range": SPAN, "platform_width": NOT_NEGATIVE}


@configclass
class MeshFloatingRingTerrainCfg(SubTerrainBaseCfg):
    """A floating ring."""

    ring_width_range: tuple[float, float] = MISSING
    ring_height_range: tuple[float, float] = MISSING
    ring_thickness: float = MISSING
    platform_width: float = 1.0

    _ranges: ClassVar[Ranges] = {
        "ring_width_range ring_height_range": SPAN,
        "ring_thickness": POSITIVE,
        "platform_width": NOT_NEGATIVE,
    }


@configclass
class MeshStarTerrainCfg(SubTerrainBaseCfg):
    """A star of bars."""

    num_bars: int = MISSING
    bar_width_range: tuple[float, float] = MISSING
    bar_height_range: tuple[float, float] = MISSING
    platform_width: float = 1.0

    _ranges: ClassVar[Ranges] = {
        "num_bars": COUNT,
        "bar_width_range bar_height_range": SPAN,
        "platform_width": NOT_NEGATIVE,
    }


@configclass
class MeshRepeatedObjectsTerrainCfg(SubTerrainBaseCfg):
    """Base of terrains strewn with objects."""

    @configclass
    class ObjectCfg:
        """How many objects, how high."""

        num_objects: int = MISSING
        height: float = MISSING

        _ranges: ClassVar[Ranges] = {"num_objects": COUNT, "height": POSITIVE}

    object_type: Literal["cylinder", "box", "cone"] | Callable[..., Any] = MISSING
    object_params_start: ObjectCfg = MISSING
    object_params_end: ObjectCfg = MISSING
    max_height_noise: float | None = None
    abs_height_noise: tuple[float, float] = (0.0, 0.0)
    rel_height_noise: tuple[float, float] = (1.0, 1.0)
    platform_width: float = 1.0
    platform_height: float = -1.0

    _ranges: ClassVar[Ranges] = {
        "max_height_noise": NOT_NEGATIVE,
        "abs_height_noise rel_height_noise": SPAN,
        "platform_width": NOT_NEGATIVE,
        "platform_height": FINITE,
    }


@configclass
class MeshRepeatedPyramidsTerrainCfg(MeshRepeatedObjectsTerrainCfg):
    """Strewn with pyramids."""

    @configclass
    class ObjectCfg(MeshRepeatedObjectsTerrainCfg.ObjectCfg):
        """Size and tilt of the objects."""

        radius: float = MISSING
        max_yx_angle: float = 0.0
        degrees: bool = True

        _ranges: ClassVar[Ranges] = {"radius": POSITIVE, "max_yx_angle": NOT_NEGATIVE}

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

        _ranges: ClassVar[Ranges] = {"size": POSITIVE, "max_yx_angle": NOT_NEGATIVE}

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

        _ranges: ClassVar[Ranges] = {"radius": POSITIVE, "max_yx_angle": NOT_NEGATIVE}

    object_type: Literal["cylinder", "box", "cone"] | Callable[..., Any] = "cylinder"
    object_params_start: ObjectCfg = MISSING
    object_params_end: ObjectCfg = MISSING
