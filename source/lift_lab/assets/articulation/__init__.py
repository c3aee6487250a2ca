"""Articulations: trees of bodies connected by joints, with actuators."""

from .articulation import Articulation
from .articulation_cfg import ArticulationCfg
from .articulation_data import ArticulationData
from .mirror_cfg import ArticulationMirrorCfg

__all__ = ["Articulation", "ArticulationCfg", "ArticulationData", "ArticulationMirrorCfg"]
