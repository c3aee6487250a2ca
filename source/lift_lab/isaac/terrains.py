"""Generated terrains. Lengths in m."""

from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Literal, NoReturn

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import (
    COUNT,
    COUNT_OR_ZERO,
    FINITE,
    NOT_NEGATIVE,
    NOT_NEGATIVE_OR_INF,
    POSITIVE,
    SEED,
    SPAN,
    SPAN_OR_INF,
    Ranges,
)

from .finder import place
from .table import TERRAINS


def not_generated(difficulty: float, cfg: Any) -> NoReturn:
    """Refuse to make a patch; stands where Isaac Lab has the function that makes it.

    Raises:
        ConfigError: always.
    """
    raise TERRAINS.error(name=type(cfg).__name__)


@configclass
class FlatPatchSamplingCfg(ConfigBase):
    """Search for flat places."""

    num_patches: int = MISSING
    patch_radius: float | list[float] = MISSING
    x_range: tuple[float, float] = (-1e6, 1e6)
    y_range: tuple[float, float] = (-1e6, 1e6)
    z_range: tuple[float, float] = (-1e6, 1e6)
    max_height_diff: float = MISSING

    _ranges: ClassVar[Ranges] = {
        "num_patches": COUNT,
        "patch_radius": POSITIVE,
        "x_range y_range z_range": SPAN_OR_INF,
        "max_height_diff": NOT_NEGATIVE,
    }


@configclass
class SubTerrainBaseCfg(ConfigBase):
    """Base of the patches of a generated terrain."""

    function: Callable[..., Any] = not_generated
    proportion: float = 1.0
    size: tuple[float, float] = (10.0, 10.0)
    flat_patch_sampling: dict[str, FlatPatchSamplingCfg] | None = None

    _ranges: ClassVar[Ranges] = {"proportion": NOT_NEGATIVE, "size": POSITIVE}


@configclass
class TerrainGeneratorCfg(ConfigBase):
    """A generated terrain."""

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
        """Number and height of objects."""

        num_objects: int = MISSING
        height: float = MISSING

        _ranges: ClassVar[Ranges] = {"num_objects": COUNT, "height": POSITIVE}

    object_type: Literal["cylinder", "box", "cone"] | Callable[..., Any] = MISSING
    object_params_start: Annotated[Any, ObjectCfg] = MISSING
    object_params_end: Annotated[Any, ObjectCfg] = MISSING
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


_STAIRS = {"step_height_range": (0.05, 0.23), "step_width": 0.3, "platform_width": 3.0, "border_width": 1.0}
_SLOPE = {"slope_range": (0.0, 0.4), "platform_width": 2.0, "border_width": 0.25}

ROUGH_TERRAINS_CFG = TerrainGeneratorCfg(
    size=(8.0, 8.0),
    border_width=20.0,
    num_rows=10,
    num_cols=20,
    sub_terrains={
        "pyramid_stairs": MeshPyramidStairsTerrainCfg(proportion=0.2, **_STAIRS),
        "pyramid_stairs_inv": MeshInvertedPyramidStairsTerrainCfg(proportion=0.2, **_STAIRS),
        "boxes": MeshRandomGridTerrainCfg(
            proportion=0.2, grid_width=0.45, grid_height_range=(0.05, 0.2), platform_width=2.0
        ),
        "random_rough": HfRandomUniformTerrainCfg(
            proportion=0.2, noise_range=(0.02, 0.10), noise_step=0.02, border_width=0.25
        ),
        "hf_pyramid_slope": HfPyramidSlopedTerrainCfg(proportion=0.1, **_SLOPE),
        "hf_pyramid_slope_inv": HfInvertedPyramidSlopedTerrainCfg(proportion=0.1, **_SLOPE),
    },
)
"""Isaac Lab's rough terrain: stairs, blocks, noise and slopes in equal parts."""


place(__name__)
