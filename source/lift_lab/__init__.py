"""lift_lab"""

from .isaac import finder as _finder

_finder.install()
