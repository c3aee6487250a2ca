"""For editors: names that the import hook of :mod:`lift_lab.isaac` gives this module at run time."""

from .isaac.devices import *  # noqa: F403
