"""Assets of a scene: articulations, rigid objects and static things."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from .articulation import *
from .asset_base import *
from .asset_base_cfg import *
from .deformable_object import *
from .rigid_object import *

if TYPE_CHECKING:
    from ..isaac.assets import *
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
