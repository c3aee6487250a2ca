"""Spawners: configs that become a MjSpec, by loading or authoring USD."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from .from_files import *
from .lights import *
from .materials import *
from .meshes import *
from .shapes import *
from .spawner_cfg import *

if TYPE_CHECKING:
    from ...isaac.spawners import *
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
