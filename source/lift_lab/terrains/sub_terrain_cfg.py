"""Configs of a generated terrain's patches (data only; names of Isaac Lab's). Lengths in m."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING
from typing import Any, ClassVar, NoReturn

from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.ranges import COUNT, NOT_NEGATIVE, POSITIVE, SPAN_OR_INF, Ranges


@configclass
class FlatPatchSamplingCfg:
    """Where flat places are looked for."""

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


def not_generated(difficulty: float, cfg: SubTerrainBaseCfg) -> NoReturn:
    """Stands where Isaac Lab has the function that makes the patch.

    Raises:
        ConfigError: always.
    """
    raise ConfigError(f"{type(cfg).__name__}: terrains are not generated; use terrain_type='plane'")


@configclass
class SubTerrainBaseCfg:
    """Base of the patches of a generated terrain."""

    function: Callable[..., Any] = not_generated
    proportion: float = 1.0
    size: tuple[float, float] = (10.0, 10.0)
    flat_patch_sampling: dict[str, FlatPatchSamplingCfg] | None = None

    _ranges: ClassVar[Ranges] = {"proportion": NOT_NEGATIVE, "size": POSITIVE}
