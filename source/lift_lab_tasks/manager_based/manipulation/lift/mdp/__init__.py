"""Terms of the lift task, beside all of :mod:`lift_lab.envs.mdp`."""

from lift_lab.envs.mdp import *

from .commands import *
from .curriculums import *
from .metrics import *
from .observations import *
from .rewards import *
from .terminations import *
