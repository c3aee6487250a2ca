"""Base class of the actuator models: the joints of a group and their resolved gains and limits."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.utils.errors import ConfigError
from lift_lab.utils.saved_state import Stateful
from lift_lab.utils.string import resolve_matching_names_values
from lift_lab.utils.types import ArticulationActions

if TYPE_CHECKING:
    from .actuator_cfg import ActuatorBaseCfg

_UNSET = torch.empty(0)


class ActuatorBase(ABC, Stateful):
    """A group of joints driven by one model (Isaac Lab's class of this name, with the same hooks to override).

    Tensors have shape (num_envs, num_joints of the group); joint efforts in N m or N.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_device", "_joint_indices", "_joint_names", "_num_envs", "joint_property_resolution_table"}
    )

    is_implicit_model: ClassVar[bool] = False
    """Whether the engine computes the effort."""
    gear_ratio: torch.Tensor | float = 1.0
    """Motor speed per joint speed, as ``data.gear_ratio`` reports it."""

    computed_effort: torch.Tensor
    """Effort of the last :meth:`compute` before clipping."""
    applied_effort: torch.Tensor
    """Effort of the last :meth:`compute` after clipping."""
    effort_limit: torch.Tensor = _UNSET
    """Effort limit of the model. For an implicit model it equals :attr:`effort_limit_sim`."""
    effort_limit_sim: torch.Tensor = _UNSET
    """Effort limit of the engine. For an explicit model it is 1e9 unless the config sets it."""
    velocity_limit: torch.Tensor = _UNSET
    """Velocity limit of the model. Of an implicit model the same as :attr:`velocity_limit_sim`."""
    velocity_limit_sim: torch.Tensor = _UNSET
    """Velocity limit of the joint: the config's, else the file's. MuJoCo does not clamp velocities."""
    stiffness: torch.Tensor
    damping: torch.Tensor
    armature: torch.Tensor
    friction: torch.Tensor
    dynamic_friction: torch.Tensor
    viscous_friction: torch.Tensor
    joint_property_resolution_table: dict[str, list[list]]
    """Rows of (joint, index, file's value, config's value or ``"Not Specified"``, value used) by property. Only joints
    whose config sets no value, or another value than the file, have a row."""

    cfg: Any
    """The group's config; a sub-class may narrow its type."""

    _DEFAULT_MAX_EFFORT_SIM: ClassVar[float] = 1.0e9
    """Effort limit in the engine of an explicit model whose config gives none, in N m or N."""

    def __init__(
        self,
        cfg: ActuatorBaseCfg,
        joint_names: list[str],
        joint_ids: slice | torch.Tensor | Sequence[int],
        num_envs: int,
        device: str,
        stiffness: torch.Tensor | float = 0.0,
        damping: torch.Tensor | float = 0.0,
        armature: torch.Tensor | float = 0.0,
        friction: torch.Tensor | float = 0.0,
        dynamic_friction: torch.Tensor | float = 0.0,
        viscous_friction: torch.Tensor | float = 0.0,
        effort_limit: torch.Tensor | float = torch.inf,
        velocity_limit: torch.Tensor | float = torch.inf,
    ):
        """Resolve the config: its values where it gives any, else those of the asset's file.

        What a sub-class leaves in :attr:`stiffness`, :attr:`damping`, :attr:`armature`, the frictions and the limits at
        the end of its own ``__init__`` is what the articulation reports and gives to the engine.

        Args:
            cfg: the group's config.
            joint_names: names of the group's joints.
            joint_ids: their indices in the articulation.
            num_envs: number of environments.
            device: torch device.
            stiffness: the file's value, as all that follow: one number, or shape (num_envs, num_joints).

        Raises:
            ConfigError: a name pattern that matches no joint, or a tensor of another shape.
            TypeError: a value of the config that is neither a number nor a dict.
        """
        self.cfg = cfg
        self._joint_names = joint_names
        self._joint_indices = joint_ids
        self._num_envs = num_envs
        self._device = device
        self.joint_property_resolution_table = {}
        effort_limit_sim = cfg.effort_limit_sim
        if not self.is_implicit_model and effort_limit_sim is None:
            effort_limit_sim = self._DEFAULT_MAX_EFFORT_SIM
        for name, given, of_file in (
            ("velocity_limit_sim", cfg.velocity_limit_sim, velocity_limit),
            ("effort_limit_sim", effort_limit_sim, effort_limit),
            ("stiffness", cfg.stiffness, stiffness),
            ("damping", cfg.damping, damping),
            ("armature", cfg.armature, armature),
            ("friction", cfg.friction, friction),
            ("dynamic_friction", cfg.dynamic_friction, dynamic_friction),
            ("viscous_friction", cfg.viscous_friction, viscous_friction),
        ):
            value = self._parse_joint_parameter(given, of_file)
            setattr(self, name, value)
            self._record_resolution(name, given, of_file, value)
        self.velocity_limit = self._parse_joint_parameter(cfg.velocity_limit, self.velocity_limit_sim)
        default = effort_limit if cfg.effort_limit is None else self.effort_limit_sim
        self.effort_limit = self._parse_joint_parameter(cfg.effort_limit, default)
        shape = (num_envs, len(joint_names))
        self.computed_effort = torch.zeros(shape, device=device)
        self.applied_effort = torch.zeros(shape, device=device)

    def __str__(self) -> str:
        kind = "implicit" if self.is_implicit_model else "explicit"
        return f"{type(self).__name__} ({kind}) of {self.num_joints} joints: {', '.join(self.joint_names)}"

    @property
    def runs_in_engine(self) -> bool:
        """Whether :meth:`compute` need not be called before each physics step: the engine does all that it does."""
        return False

    @property
    def num_joints(self) -> int:
        """Joints in the group."""
        return len(self._joint_names)

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints in the group."""
        return self._joint_names

    @property
    def joint_indices(self) -> slice | torch.Tensor | Sequence[int]:
        """Indices of the group's joints in the articulation."""
        return self._joint_indices

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None) -> None:
        """Forget the internal state of some environments; None means all."""

    def start_episodes(self, env_ids: torch.Tensor, control_action: ArticulationActions) -> None:
        """Take note of the targets with which some environments start, after they were reset.

        Args:
            env_ids: the environments, a LongTensor.
            control_action: targets of the group's joints in these environments.
        """

    @abstractmethod
    def compute(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> ArticulationActions:
        """Compute the effort for targets at a joint state. It is ``joint_efforts`` of the result.

        Args:
            control_action: position, velocity and effort targets of the group's joints.
            joint_pos: positions in rad or m, shape (num_envs, num_joints).
            joint_vel: velocities in rad/s or m/s, same shape.
        """

    def _parse_joint_parameter(
        self, cfg_value: dict[str, float] | float | None, default_value: torch.Tensor | float | None
    ) -> torch.Tensor:
        """A parameter of every joint of the group, shape (num_envs, num_joints).

        Args:
            cfg_value: a number for all joints, ``{joint name pattern: number}``, or None for the default. Joints that
                no pattern names keep the default, or are 0 where there is none.
            default_value: a number, or a tensor of shape (num_envs, num_joints).

        Raises:
            ConfigError: neither is given, a pattern matches no joint, or the tensor has another shape.
            TypeError: a value of another type.
        """
        shape = (self._num_envs, self.num_joints)
        parameter = torch.zeros(shape, device=self._device)
        if isinstance(default_value, torch.Tensor):
            if default_value.shape != shape:
                raise ConfigError(
                    f"{type(self).__name__}: the default value has shape {tuple(default_value.shape)}, expected {shape}"
                )
            parameter[:] = default_value
        elif isinstance(default_value, (int, float)):
            parameter[:] = float(default_value)
        elif default_value is not None:
            raise TypeError(
                f"{type(self).__name__}: the default value must be a number or a tensor, got {default_value!r}"
            )
        if isinstance(cfg_value, dict):
            try:
                indices, _, values = resolve_matching_names_values(cfg_value, self._joint_names)
            except ValueError as error:
                raise ConfigError(f"{type(self).__name__}: {error}") from error
            parameter[:, indices] = torch.tensor(values, dtype=torch.float32, device=self._device)
        elif isinstance(cfg_value, (int, float)):
            parameter[:] = float(cfg_value)
        elif cfg_value is not None:
            raise TypeError(f"{type(self).__name__}: a parameter must be a number or a dict, got {cfg_value!r}")
        elif default_value is None:
            raise ConfigError(f"{type(self).__name__}: a parameter is None and has no default")
        return parameter

    def _record_resolution(
        self,
        name: str,
        given: dict[str, float] | float | None,
        of_file: torch.Tensor | float,
        value: torch.Tensor,
    ) -> None:
        """Add a property's rows to the resolution table, where the config says nothing or differs from the file."""
        file_values = torch.as_tensor(of_file, dtype=torch.float32, device=value.device).expand_as(value)
        if given is not None and torch.allclose(file_values, value):
            return
        ids = range(self.num_joints) if isinstance(self._joint_indices, slice) else self._joint_indices
        used, said = value[0].tolist(), file_values[0].tolist()
        self.joint_property_resolution_table[name] = [
            [joint, int(ids[i]), said[i], "Not Specified" if given is None else used[i], used[i]]
            for i, joint in enumerate(self._joint_names)
        ]

    def _clip_effort(self, effort: torch.Tensor) -> torch.Tensor:
        """Clip at the effort limit."""
        return torch.clamp(effort, -self.effort_limit, self.effort_limit)

    def _pd_effort(
        self, control_action: ArticulationActions, joint_pos: torch.Tensor, joint_vel: torch.Tensor
    ) -> torch.Tensor:
        """The PD law kp (q* - q) + kd (qd* - qd) + tau_ff before clipping."""
        position, velocity = control_action.joint_positions, control_action.joint_velocities
        effort = control_action.joint_efforts
        assert position is not None
        assert velocity is not None
        assert effort is not None
        return self.stiffness * (position - joint_pos) + self.damping * (velocity - joint_vel) + effort
