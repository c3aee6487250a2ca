"""Command terms: goals that are drawn again at intervals."""

from .commands_cfg import *
from .null_command import *
from .pose_2d_command import *
from .pose_command import *
from .velocity_command import *
