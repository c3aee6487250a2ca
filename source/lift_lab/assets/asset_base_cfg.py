"""Config that all assets share."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from lift_lab.sim.spawners.spawner_cfg import SpawnerCfg
from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import FINITE, Ranges

from .asset_base import AssetBase

__all__ = [
    "AssetBaseCfg",
]


@configclass
class AssetBaseCfg(ConfigBase):
    """A thing of the scene. With this class itself: a static one (table, ground, light)."""

    @configclass
    class InitialStateCfg:
        """Initial pose of the asset in the environment's frame."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        """Position in m."""
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
        """Orientation (w, x, y, z); normalised when used."""

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = AssetBase
    prim_path: str = MISSING
    """Isaac Lab's prim path. ``{ENV_REGEX_NS}`` stands for the environment; the last part names the prim."""
    spawn: SpawnerCfg | None = None
    """Spawner: the file, shape or light that the asset is made of."""
    init_state: Annotated[Any, InitialStateCfg] = InitialStateCfg()
    """Initial pose."""
    collision_group: Literal[0, -1] = 0
    """Isaac Lab's collision group. Environments never collide here."""
    debug_vis: bool = False
    """Whether the asset's markers are drawn where a viewer shows markers."""
