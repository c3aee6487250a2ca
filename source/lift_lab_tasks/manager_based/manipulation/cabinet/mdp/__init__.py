"""Terms of the cabinet task, beside all of :mod:`lift_lab.envs.mdp`.

They read two frame transformers of the scene. The targets of ``ee_frame`` are the tool centre and the two fingertips.
The first target of ``cabinet_frame`` is the handle, with the orientation of a hand that grasps it.
"""

from lift_lab.envs.mdp import *

from .observations import *
from .rewards import *
from .success import *
