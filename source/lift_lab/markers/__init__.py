"""Visualisation markers."""

from .config import *
from .visualization_markers import *
