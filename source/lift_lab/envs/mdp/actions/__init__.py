"""Action terms: how the policy's numbers become targets of joints."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from .actions_cfg import *
from .binary_joint_actions import *
from .joint_actions import *
from .joint_actions_to_limits import *
from .non_holonomic_actions import *
from .task_space_actions import *

if TYPE_CHECKING:
    from ....isaac.mdp import SurfaceGripperBinaryAction as SurfaceGripperBinaryAction
    from ....isaac.mdp import SurfaceGripperBinaryActionCfg as SurfaceGripperBinaryActionCfg
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
