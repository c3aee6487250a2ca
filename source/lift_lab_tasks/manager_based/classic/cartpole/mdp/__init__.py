"""Terms of the cart-pole, beside all of :mod:`lift_lab.envs.mdp`."""

from lift_lab.envs.mdp import *

from .rewards import *
from .success import *
