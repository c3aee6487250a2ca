"""Terms of the cabinet task, beside all of :mod:`lift_lab.envs.mdp`.

They read two frame transformers of the scene: ``ee_frame``, whose targets are the tool centre and then the two
fingertips, and ``cabinet_frame``, whose first target is the handle, turned as a hand that grasps it would be.
"""

from lift_lab.envs.mdp import *

from .observations import ee_pos, ee_quat, fingertips_pos, rel_ee_drawer_distance
from .rewards import (
    align_ee_handle,
    align_grasp_around_handle,
    approach_ee_handle,
    approach_gripper_handle,
    grasp_handle,
    multi_stage_open_drawer,
    open_drawer_bonus,
)
from .success import drawer_is_open
