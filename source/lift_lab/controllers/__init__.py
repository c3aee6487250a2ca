"""Controllers of an arm's end effector: differential inverse kinematics and operational-space control."""

from .differential_ik import DifferentialIKController
from .differential_ik_cfg import DifferentialIKControllerCfg
from .operational_space import OperationalSpaceController
from .operational_space_cfg import OperationalSpaceControllerCfg

__all__ = [
    "DifferentialIKController",
    "DifferentialIKControllerCfg",
    "OperationalSpaceController",
    "OperationalSpaceControllerCfg",
]
