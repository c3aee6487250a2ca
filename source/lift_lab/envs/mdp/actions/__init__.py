"""Action terms: how the policy's numbers become targets of joints."""

from typing import TYPE_CHECKING

from lift_lab.isaac.finder import attributes_of

from .actions_cfg import (
    AbsBinaryJointPositionActionCfg,
    BinaryJointActionCfg,
    BinaryJointPositionActionCfg,
    BinaryJointVelocityActionCfg,
    DifferentialInverseKinematicsActionCfg,
    EMAJointPositionToLimitsActionCfg,
    JointActionCfg,
    JointEffortActionCfg,
    JointPositionActionCfg,
    JointPositionToLimitsActionCfg,
    JointVelocityActionCfg,
    NonHolonomicActionCfg,
    OperationalSpaceControllerActionCfg,
    RelativeJointPositionActionCfg,
)
from .binary_joint_actions import (
    AbsBinaryJointPositionAction,
    BinaryJointAction,
    BinaryJointPositionAction,
    BinaryJointVelocityAction,
)
from .joint_actions import (
    JointAction,
    JointEffortAction,
    JointPositionAction,
    JointVelocityAction,
    RelativeJointPositionAction,
)
from .joint_actions_to_limits import EMAJointPositionToLimitsAction, JointPositionToLimitsAction
from .non_holonomic_actions import NonHolonomicAction
from .task_space_actions import DifferentialInverseKinematicsAction, OperationalSpaceControllerAction

if TYPE_CHECKING:
    from ....isaac.mdp import SurfaceGripperBinaryAction, SurfaceGripperBinaryActionCfg
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
