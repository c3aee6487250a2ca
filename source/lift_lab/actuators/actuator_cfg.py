"""Actuator configs (names of Isaac Lab's). Values may be one number or ``{joint name pattern: number}``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, Literal

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import COUNT_OR_ZERO, FINITE, NOT_NEGATIVE_OR_INF, POSITIVE_OR_INF, Ranges

from .actuator_net import ActuatorNetLSTM, ActuatorNetMLP
from .actuator_pd import DCMotor, DelayedPDActuator, IdealPDActuator, ImplicitActuator, RemotizedPDActuator


@configclass
class ActuatorBaseCfg(ConfigBase):
    """Settings of a group of joints. Units: N m, N m/rad, ... for hinges; N, N/m, ... for slides."""

    class_type: type = MISSING
    joint_names_expr: list[str] = MISSING
    """Patterns of the joints in the group (full match)."""
    effort_limit: dict[str, float] | float | None = None
    """Limit of an explicit model's effort; None keeps the file's. Of implicit models the same as
    :attr:`effort_limit_sim`: both given and different is an error."""
    velocity_limit: dict[str, float] | float | None = None
    """Velocity limit of an explicit model: kept in ``data.soft_joint_vel_limits``; a DC motor's no-load speed. Does not
    count for implicit models, whose limit is :attr:`velocity_limit_sim`; both given and different is an error."""
    effort_limit_sim: dict[str, float] | float | None = None
    """Limit of the effort the engine applies. None keeps the file's for implicit models, and is 1e9 for explicit
    ones."""
    velocity_limit_sim: dict[str, float] | float | None = None
    """PhysX's velocity limit. Kept in ``data.joint_vel_limits``; MuJoCo does not clamp velocities."""
    stiffness: dict[str, float] | float | None = MISSING
    """Position gain at the joint, at least 0. None keeps the file's drive (docs/usd.md, "Drives in a scene")."""
    damping: dict[str, float] | float | None = MISSING
    """Velocity gain at the joint, at least 0. None keeps the file's drive."""
    armature: dict[str, float] | float | None = None
    """Reflected rotor inertia. None keeps the USD file's."""
    friction: dict[str, float] | float | None = None
    """Dry friction effort (MuJoCo's frictionloss). None keeps the USD file's."""
    dynamic_friction: dict[str, float] | float | None = None
    """PhysX's friction while moving: MuJoCo has one dry friction, :attr:`friction`."""
    viscous_friction: dict[str, float] | float | None = None
    """Effort per joint velocity (MuJoCo's joint damping). None keeps the USD file's."""

    _ranges: ClassVar[Ranges] = {
        (
            "effort_limit velocity_limit effort_limit_sim velocity_limit_sim stiffness damping "
            "armature friction dynamic_friction viscous_friction"
        ): NOT_NEGATIVE_OR_INF,
    }


@configclass
class ImplicitActuatorCfg(ActuatorBaseCfg):
    """A PD controller inside the engine's step, integrated implicitly."""

    class_type: type = ImplicitActuator


@configclass
class IdealPDActuatorCfg(ActuatorBaseCfg):
    """A PD controller computed in torch each physics step and clipped at :attr:`effort_limit`."""

    class_type: type = IdealPDActuator


@configclass
class DCMotorCfg(IdealPDActuatorCfg):
    """An ideal PD controller behind a DC motor's torque-speed line."""

    class_type: type = DCMotor
    saturation_effort: float = MISSING
    """Stall effort of the motor."""

    _ranges: ClassVar[Ranges] = {"saturation_effort": POSITIVE_OR_INF}


@configclass
class DelayedPDActuatorCfg(IdealPDActuatorCfg):
    """An ideal PD controller whose targets arrive late, by a lag drawn at each reset."""

    class_type: type = DelayedPDActuator
    min_delay: int = 0
    """Least lag in physics steps."""
    max_delay: int = 0
    """Greatest lag in physics steps."""

    _ranges: ClassVar[Ranges] = {"min_delay max_delay": COUNT_OR_ZERO}


@configclass
class RemotizedPDActuatorCfg(DelayedPDActuatorCfg):
    """A delayed PD controller whose effort limit depends on the joint's angle."""

    class_type: type = RemotizedPDActuator
    joint_parameter_lookup: list[list[float]] = MISSING
    """Rows of joint angle (rad, ascending), transmission ratio, effort limit (N m)."""

    _ranges: ClassVar[Ranges] = {"joint_parameter_lookup": FINITE}


@configclass
class ActuatorNetLSTMCfg(DCMotorCfg):
    """A recurrent network from position error and velocity to effort, clipped as a DC motor."""

    class_type: type = ActuatorNetLSTM
    stiffness: dict[str, float] | float | None = None
    damping: dict[str, float] | float | None = None
    network_file: str = MISSING
    """Path of the TorchScript file."""


@configclass
class ActuatorNetMLPCfg(DCMotorCfg):
    """A network from a history of position errors and velocities to effort, clipped as a DC motor."""

    class_type: type = ActuatorNetMLP
    stiffness: dict[str, float] | float | None = None
    damping: dict[str, float] | float | None = None
    network_file: str = MISSING
    """Path of the TorchScript file."""
    pos_scale: float = MISSING
    """Factor of the position errors."""
    vel_scale: float = MISSING
    """Factor of the velocities."""
    torque_scale: float = MISSING
    """Factor of the network's answer."""
    input_order: Literal["pos_vel", "vel_pos"] = MISSING
    """Whether position errors or velocities come first."""
    input_idx: Sequence[int] = MISSING
    """Physics steps that the network reads: 0 is the current step, n is n steps ago."""

    _ranges: ClassVar[Ranges] = {"pos_scale vel_scale torque_scale": FINITE, "input_idx": COUNT_OR_ZERO}
