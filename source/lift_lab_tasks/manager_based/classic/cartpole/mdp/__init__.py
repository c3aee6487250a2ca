"""Terms of the cart-pole, beside all of :mod:`lift_lab.envs.mdp`."""

from lift_lab.envs.mdp import *

from .rewards import joint_pos_target_l2
from .success import pole_balanced
