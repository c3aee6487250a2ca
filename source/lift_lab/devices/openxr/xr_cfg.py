"""Where a headset's world is anchored in the scene: data only."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Any, ClassVar

from lift_lab.sensors import CameraCfg
from lift_lab.utils import configclass
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, Ranges


class XrAnchorRotationMode(Enum):
    """How the anchor turns with the prim that it follows."""

    FIXED = "fixed"
    FOLLOW_PRIM = "follow_prim"
    FOLLOW_PRIM_SMOOTHED = "follow_prim_smoothed"
    CUSTOM = "custom_rotation"


@configclass
class XrCfg:
    """An XR anchor: accepted as data."""

    anchor_pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position in m."""
    anchor_rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Orientation (w, x, y, z)."""
    anchor_prim_path: str | None = None
    anchor_rotation_mode: XrAnchorRotationMode = XrAnchorRotationMode.FIXED
    anchor_rotation_smoothing_time: float = 1.0
    anchor_rotation_custom_func: Callable[..., Any] | None = None
    near_plane: float = 0.15
    fixed_anchor_height: bool = True

    _ranges: ClassVar[Ranges] = {
        "anchor_pos anchor_rot": FINITE,
        "anchor_rotation_smoothing_time near_plane": NOT_NEGATIVE,
    }


def remove_camera_configs(env_cfg: Any) -> Any:
    """Set every camera of the scene to None and drop observation terms that read one (Isaac Lab's).

    Args:
        env_cfg: an environment config, changed in place and returned.
    """
    cameras = [name for name, value in vars(env_cfg.scene).items() if isinstance(value, CameraCfg)]
    for name in cameras:
        setattr(env_cfg.scene, name, None)
    for group in vars(env_cfg.observations).values():
        for name, term in list(getattr(group, "__dict__", {}).items()):
            entities = getattr(term, "params", None) or {}
            if any(getattr(entity, "name", None) in cameras for entity in entities.values()):
                setattr(group, name, None)
    return env_cfg
