"""Configs of the action terms, with Isaac Lab's names."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from lift_lab.controllers import DifferentialIKControllerCfg, OperationalSpaceControllerCfg
from lift_lab.isaac.finder import attributes_of
from lift_lab.managers import ActionTermCfg
from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import FINITE, FRACTION, NOT_NEGATIVE, Ranges

from . import (
    binary_joint_actions,
    joint_actions,
    joint_actions_to_limits,
    non_holonomic_actions,
    task_space_actions,
)

__all__ = [
    "AbsBinaryJointPositionActionCfg",
    "BinaryJointActionCfg",
    "BinaryJointPositionActionCfg",
    "BinaryJointVelocityActionCfg",
    "DifferentialInverseKinematicsActionCfg",
    "EMAJointPositionToLimitsActionCfg",
    "JointActionCfg",
    "JointEffortActionCfg",
    "JointPositionActionCfg",
    "JointPositionToLimitsActionCfg",
    "JointVelocityActionCfg",
    "NonHolonomicActionCfg",
    "OperationalSpaceControllerActionCfg",
    "RelativeJointPositionActionCfg",
]

# -- joints


@configclass
class JointActionCfg(ActionTermCfg):
    """Base config of the joint actions."""

    joint_names: list[str] = MISSING
    """Names or patterns of the joints."""
    scale: float | dict[str, float] = 1.0
    """Factor of the raw action: one number, or by joint name pattern (others have 1)."""
    offset: float | dict[str, float] = 0.0
    """Offset of the scaled action: one number, or a number for each joint name pattern (others have 0)."""
    preserve_order: bool = False
    """Whether the action's columns follow :attr:`joint_names`, and not the articulation's order."""

    _ranges: ClassVar[Ranges] = {"scale offset": FINITE}


@configclass
class JointPositionActionCfg(JointActionCfg):
    """Config of :class:`JointPositionAction`."""

    class_type: type = joint_actions.JointPositionAction

    use_default_offset: bool = True
    """Whether the default joint positions replace :attr:`offset`."""


@configclass
class RelativeJointPositionActionCfg(JointActionCfg):
    """Config of :class:`RelativeJointPositionAction`."""

    class_type: type = joint_actions.RelativeJointPositionAction

    use_zero_offset: bool = True
    """Whether zero replaces :attr:`offset`."""


@configclass
class JointVelocityActionCfg(JointActionCfg):
    """Config of :class:`JointVelocityAction`."""

    class_type: type = joint_actions.JointVelocityAction

    use_default_offset: bool = True
    """Whether the default joint velocities replace :attr:`offset`."""


@configclass
class JointEffortActionCfg(JointActionCfg):
    """Config of :class:`JointEffortAction`."""

    class_type: type = joint_actions.JointEffortAction


@configclass
class JointPositionToLimitsActionCfg(ActionTermCfg):
    """Config of :class:`JointPositionToLimitsAction`."""

    class_type: type = joint_actions_to_limits.JointPositionToLimitsAction

    joint_names: list[str] = MISSING
    """Names or patterns of the joints."""
    scale: float | dict[str, float] = 1.0
    """Factor of the raw action: one number, or by joint name pattern (others have 1)."""
    rescale_to_limits: bool = True
    """Whether [-1, 1] is mapped onto the soft limits; otherwise the scaled action is the target."""
    preserve_order: bool = False
    """Whether the action's columns follow :attr:`joint_names`, and not the articulation's order."""

    _ranges: ClassVar[Ranges] = {"scale": FINITE}


@configclass
class EMAJointPositionToLimitsActionCfg(JointPositionToLimitsActionCfg):
    """Config of :class:`EMAJointPositionToLimitsAction`."""

    class_type: type = joint_actions_to_limits.EMAJointPositionToLimitsAction

    alpha: float | dict[str, float] = 1.0
    """Weight of the new target in the average, within [0, 1]: one number, or by joint name pattern."""

    _ranges: ClassVar[Ranges] = {"alpha": FRACTION}


# -- grippers


@configclass
class BinaryJointActionCfg(ActionTermCfg):
    """Base config of the binary actions."""

    joint_names: list[str] = MISSING
    """Names or patterns of the joints."""
    open_command_expr: dict[str, float] = MISSING
    """Target when open, by joint name pattern; it must cover every joint."""
    close_command_expr: dict[str, float] = MISSING
    """Target when closed, by joint name pattern; it must cover every joint."""
    min_close_time_s: float = 0.0
    """Time in s for which a gripper that closes ignores an action that opens it."""

    _ranges: ClassVar[Ranges] = {"open_command_expr close_command_expr": FINITE, "min_close_time_s": NOT_NEGATIVE}


@configclass
class BinaryJointPositionActionCfg(BinaryJointActionCfg):
    """Config of :class:`BinaryJointPositionAction`."""

    class_type: type = binary_joint_actions.BinaryJointPositionAction


@configclass
class BinaryJointVelocityActionCfg(BinaryJointActionCfg):
    """Config of :class:`BinaryJointVelocityAction`."""

    class_type: type = binary_joint_actions.BinaryJointVelocityAction


@configclass
class AbsBinaryJointPositionActionCfg(ActionTermCfg):
    """Config of :class:`AbsBinaryJointPositionAction`."""

    class_type: type = binary_joint_actions.AbsBinaryJointPositionAction

    joint_names: list[str] = MISSING
    """Names or patterns of the joints."""
    open_command_expr: dict[str, float] = MISSING
    """Target when open, by joint name pattern; it must cover every joint."""
    close_command_expr: dict[str, float] = MISSING
    """Target when closed, by joint name pattern; it must cover every joint."""
    threshold: float = 0.5
    """The action at which open and closed meet."""
    positive_threshold: bool = True
    """Whether open is above the threshold, or below it."""
    min_close_time_s: float = 0.0
    """Time in s for which a gripper that closes ignores an action that opens it."""

    _ranges: ClassVar[Ranges] = {
        "open_command_expr close_command_expr threshold": FINITE,
        "min_close_time_s": NOT_NEGATIVE,
    }


# -- mobile bases


@configclass
class NonHolonomicActionCfg(ActionTermCfg):
    """Config of :class:`NonHolonomicAction`."""

    class_type: type = non_holonomic_actions.NonHolonomicAction

    body_name: str = MISSING
    """Body whose heading counts."""
    x_joint_name: str = MISSING
    """Joint along x."""
    y_joint_name: str = MISSING
    """Joint along y."""
    yaw_joint_name: str = MISSING
    """Joint about z."""
    scale: tuple[float, float] = (1.0, 1.0)
    """Factors of forward speed and yaw rate."""
    offset: tuple[float, float] = (0.0, 0.0)
    """Offset of the scaled actions."""

    _ranges: ClassVar[Ranges] = {"scale offset": FINITE}


# -- end effectors


@configclass
class DifferentialInverseKinematicsActionCfg(ActionTermCfg):
    """Config of :class:`DifferentialInverseKinematicsAction`."""

    @configclass
    class OffsetCfg:
        """Pose of the controlled frame in the body's frame."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        """Position in m."""
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
        """Orientation (w, x, y, z)."""

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = task_space_actions.DifferentialInverseKinematicsAction

    joint_names: list[str] = MISSING
    """Names or patterns of the joints that move."""
    body_name: str = MISSING
    """The end effector's body."""
    body_offset: OffsetCfg | None = None
    """The controlled frame in the body's frame; None is the body's own."""
    scale: float | tuple[float, ...] = 1.0
    """Factor of the raw action: one number, or one a column."""
    controller: DifferentialIKControllerCfg = MISSING
    """The controller's config."""

    _ranges: ClassVar[Ranges] = {"scale": FINITE}


@configclass
class OperationalSpaceControllerActionCfg(ActionTermCfg):
    """Config of :class:`OperationalSpaceControllerAction`."""

    @configclass
    class OffsetCfg:
        """Pose of the controlled frame in the body's frame."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        """Position in m."""
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
        """Orientation (w, x, y, z)."""

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = task_space_actions.OperationalSpaceControllerAction

    joint_names: list[str] = MISSING
    """Names or patterns of the joints that move."""
    body_name: str = MISSING
    """The end effector's body."""
    body_offset: OffsetCfg | None = None
    """The controlled frame in the body's frame; None is the body's own."""
    task_frame_rel_path: str | None = None
    """Path, below the environment, of the rigid object that is the task frame; None is the robot's root."""
    controller_cfg: OperationalSpaceControllerCfg = MISSING
    """The controller's config."""
    position_scale: float = 1.0
    """Factor of commanded positions."""
    orientation_scale: float = 1.0
    """Factor of commanded orientations."""
    wrench_scale: float = 1.0
    """Factor of commanded wrenches."""
    stiffness_scale: float = 1.0
    """Factor of commanded stiffnesses."""
    damping_ratio_scale: float = 1.0
    """Factor of commanded damping ratios."""
    nullspace_joint_pos_target: Literal["none", "zero", "default", "center"] = "none"
    """Joint positions that a redundant arm's free motion is pulled to; needs the controller's
    ``nullspace_control="position"``."""

    _ranges: ClassVar[Ranges] = {
        "position_scale orientation_scale wrench_scale stiffness_scale damping_ratio_scale": FINITE,
    }


if TYPE_CHECKING:
    from ....isaac.mdp import SurfaceGripperBinaryActionCfg as SurfaceGripperBinaryActionCfg
else:
    __getattr__, __dir__, __all__ = attributes_of(__name__)
