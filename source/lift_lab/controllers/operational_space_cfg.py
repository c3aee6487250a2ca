"""Config of the operational-space controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import COUNT_OR_ZERO, NOT_NEGATIVE, POSITIVE_SPAN, Ranges

from .operational_space import OperationalSpaceController


@configclass
class OperationalSpaceControllerCfg(ConfigBase):
    """Config of :class:`OperationalSpaceController`. Six-fold values are x, y, z, then rotations about x, y, z."""

    class_type: type = OperationalSpaceController
    """The controller."""

    target_types: Sequence[str] = MISSING
    """Parts of a command, in order: ``"pose_abs"`` (7), ``"pose_rel"`` (6), ``"wrench_abs"`` (6)."""

    motion_control_axes_task: Sequence[int] = (1, 1, 1, 1, 1, 1)
    """Axes of the task frame whose motion is controlled (1) or free (0)."""

    contact_wrench_control_axes_task: Sequence[int] = (0, 0, 0, 0, 0, 0)
    """Axes of the task frame whose contact wrench is controlled (1) or not (0)."""

    inertial_dynamics_decoupling: bool = False
    """Whether accelerations are turned into forces with the operational-space inertia."""

    partial_inertial_dynamics_decoupling: bool = False
    """Whether to ignore the coupling of translation and rotation in that inertia."""

    gravity_compensation: bool = False
    """Whether gravity is compensated."""

    impedance_mode: Literal["fixed", "variable_kp", "variable"] = "fixed"
    """Whether a command also holds the stiffness (6), or stiffness and damping ratio (12)."""

    motion_stiffness_task: float | Sequence[float] = (100.0, 100.0, 100.0, 100.0, 100.0, 100.0)
    """Stiffness of each axis in 1/s^2 with inertial decoupling, in N/m and N m/rad without."""

    motion_damping_ratio_task: float | Sequence[float] = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
    """Damping ratio of each axis: damping = 2 sqrt(stiffness) ratio."""

    motion_stiffness_limits_task: tuple[float, float] = (0.0, 1000.0)
    """Range of a commanded stiffness."""

    motion_damping_ratio_limits_task: tuple[float, float] = (0.0, 100.0)
    """Range of a commanded damping ratio."""

    contact_wrench_stiffness_task: float | Sequence[float] | None = None
    """Gain on the error of the measured contact force; None applies the wanted wrench open-loop."""

    nullspace_control: Literal["none", "position"] = "none"
    """Whether a redundant arm's free motion is pulled to joint positions."""

    nullspace_stiffness: float = 10.0
    """Stiffness of that pull in 1/s^2."""

    nullspace_damping_ratio: float = 1.0
    """Damping ratio of that pull."""

    _ranges: ClassVar[Ranges] = {
        "motion_control_axes_task contact_wrench_control_axes_task": COUNT_OR_ZERO,
        (
            "motion_stiffness_task motion_damping_ratio_task contact_wrench_stiffness_task "
            "nullspace_stiffness nullspace_damping_ratio"
        ): NOT_NEGATIVE,
        "motion_stiffness_limits_task motion_damping_ratio_limits_task": POSITIVE_SPAN,
    }
