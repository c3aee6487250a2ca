"""Visualisation markers."""

from .config import *  # noqa: F403
from .visualization_markers import VisualizationMarkers, VisualizationMarkersCfg
