"""Action terms: how the policy's numbers become targets of joints."""

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
    SurfaceGripperBinaryActionCfg,
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
from .surface_gripper_actions import SurfaceGripperBinaryAction
from .task_space_actions import DifferentialInverseKinematicsAction, OperationalSpaceControllerAction
