"""Terms of the reach task, beside all of :mod:`lift_lab.envs.mdp`."""

from lift_lab.envs.mdp import *

from .rewards import *
from .success import *
