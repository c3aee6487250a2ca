"""Command terms: goals that are drawn anew from time to time."""

from .commands_cfg import *
from .null_command import *
from .pose_2d_command import *
from .pose_command import *
from .velocity_command import *
