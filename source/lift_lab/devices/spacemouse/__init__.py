"""Space mice: configs only."""

from .se2_spacemouse import Se2SpaceMouse, Se2SpaceMouseCfg
from .se3_spacemouse import Se3SpaceMouse, Se3SpaceMouseCfg

__all__ = [
    "Se2SpaceMouse",
    "Se2SpaceMouseCfg",
    "Se3SpaceMouse",
    "Se3SpaceMouseCfg",
]
