"""Terms of the lift task, beside all of :mod:`lift_lab.envs.mdp`."""

from lift_lab.envs.mdp import *

from .commands import ObjectPoseCommand, ObjectPoseCommandCfg
from .curriculums import hold_gripper_while_hovering, practise_missed_goals, reach_from_afar
from .observations import object_position_in_robot_root_frame
from .rewards import object_ee_distance, object_goal_distance, object_is_lifted
from .terminations import object_reached_goal
