"""Terms of the reach task, beside all of :mod:`lift_lab.envs.mdp`."""

from lift_lab.envs.mdp import *

from .rewards import orientation_command_error, position_command_error, position_command_error_tanh
from .success import pose_reached
