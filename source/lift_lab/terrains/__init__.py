"""Terrains: planes are simulated."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from .terrain_importer import *
from .terrain_importer_cfg import *

if TYPE_CHECKING:
    from ..isaac.terrains import *
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
