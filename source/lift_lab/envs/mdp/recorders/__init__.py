"""Recorder terms: states, actions and observations of episodes."""

from .recorders import *
from .recorders_cfg import *
