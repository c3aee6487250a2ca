"""Surface gripper: a type for configs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from lift_lab.utils.errors import ConfigError

from ..asset_base import AssetBase

if TYPE_CHECKING:
    from .surface_gripper_cfg import SurfaceGripperCfg


class SurfaceGripper(AssetBase):
    """A type for annotations; making one raises."""

    def __init__(self, cfg: SurfaceGripperCfg):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise ConfigError(f"'{cfg.prim_path}': surface grippers are not simulated")
