"""Terms of the cabinet task, beside all of :mod:`lift_lab.envs.mdp`.

They read two frame transformers of the scene: ``ee_frame``, whose targets are the tool centre and then the two
fingertips, and ``cabinet_frame``, whose first target is the handle, turned as a hand that grasps it would be.
"""

from lift_lab.envs.mdp import *

from .observations import *
from .rewards import *
from .success import *
