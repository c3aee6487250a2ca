"""Properties of an articulation's joints: gains, limits, friction, armature, as data and in the engine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

from lift_lab.sim.ignored import note_ignored
from lift_lab.sim.physics.base import ids_tensor
from lift_lab.utils.errors import ConfigError

from ..asset_base import EnvIds, as_list
from ..body_asset import BodyAsset
from .articulation_data import ArticulationData
from .drives import NO_LIMIT

if TYPE_CHECKING:
    from lift_lab.actuators import ActuatorBase

    from .articulation_cfg import ArticulationCfg
    from .drives import Drives

JointIds = Sequence[int] | torch.Tensor | slice | None


class JointProperties(BodyAsset):
    """The part of an articulation that changes its joints' properties in all or some environments."""

    cfg: ArticulationCfg
    actuators: dict[str, ActuatorBase]
    """Actuator models by the name of their group."""

    _data: ArticulationData
    _drives: Drives
    _joint_names: list[str]
    _joint_ids: list[int]
    _dof_ids: list[int]
    _has_feedforward: bool

    @property
    def data(self) -> ArticulationData:
        """The articulation's state."""
        return self._data

    @property
    def engine_dof_ids(self) -> list[int]:
        """Ids of the joints' degrees of freedom in the compiled model."""
        return self._dof_ids

    @property
    def num_joints(self) -> int:
        """Number of hinge and slide joints."""
        return len(self._joint_names)

    def write_joint_stiffness_to_sim(
        self, stiffness: torch.Tensor | float, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set position gains, shape (n, num joints chosen)."""
        self._set("joint_stiffness", stiffness, joint_ids, env_ids, least=0.0)
        self._has_feedforward = True  # one may be zero now
        self._write_gains(joint_ids, "stiffness")

    def write_joint_damping_to_sim(
        self, damping: torch.Tensor | float, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set velocity gains, shape (n, num joints chosen)."""
        self._set("joint_damping", damping, joint_ids, env_ids, least=0.0)
        self._write_gains(joint_ids, "damping")

    def _write_gains(self, joint_ids: JointIds, name: str) -> None:
        """Give the gains called ``name`` to the engine and to the models of the joints chosen, and to no other.

        Terms of one's own set the gains of explicit models directly: what they set there stays.
        """
        data = self.data
        chosen = torch.zeros(self.num_joints, dtype=torch.bool, device=self._physics.device)
        chosen[as_list(joint_ids, self.num_joints)] = True
        for actuator in self.actuators.values():
            ids = actuator.joint_indices
            gains = getattr(data, f"joint_{name}")[:, ids]
            setattr(actuator, name, torch.where(chosen[ids], gains, getattr(actuator, name)))
        model = self._physics.model
        gain, bias = (
            self._physics.randomizable("actuator_gainprm"),
            self._physics.randomizable("actuator_biasprm"),
        )
        for i, name in enumerate(self._joint_names):
            drive = self._drives.joints.get(name)
            if drive is None or not drive.implicit:
                continue
            a = model.actuator(f"{self.name}/{name}").id
            kp = data.joint_stiffness[:, i].to(gain.dtype)
            gain[:, a, 0] = torch.where(kp > 0, kp, torch.ones_like(kp))
            bias[:, a, 1] = -kp
            bias[:, a, 2] = -data.joint_damping[:, i].to(bias.dtype)

    def write_joint_armature_to_sim(
        self, armature: torch.Tensor | float, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set reflected rotor inertias (kg m^2 or kg), shape (n, num joints chosen)."""
        self._set("joint_armature", armature, joint_ids, env_ids, least=0.0)
        self._write_dofs("dof_armature", self.data.joint_armature)
        self._physics.recompute_constants()

    def write_joint_friction_coefficient_to_sim(
        self,
        joint_friction_coeff: torch.Tensor | float,
        joint_dynamic_friction_coeff: torch.Tensor | float | None = None,
        joint_viscous_friction_coeff: torch.Tensor | float | None = None,
        joint_ids: JointIds = None,
        env_ids: EnvIds = None,
    ) -> None:
        """Set the friction of joints.

        Args:
            joint_friction_coeff: dry friction efforts in N m or N, shape (n, num joints chosen).
            joint_dynamic_friction_coeff: Isaac Lab's second dry friction. Ignored: there is one.
            joint_viscous_friction_coeff: efforts per joint velocity, same shape; None leaves them.
            joint_ids: joints, or None for all.
            env_ids: environments, or None for all.
        """
        self._set("joint_friction_coeff", joint_friction_coeff, joint_ids, env_ids, least=0.0)
        self._write_dofs("dof_frictionloss", self.data.joint_friction_coeff)
        if joint_dynamic_friction_coeff is not None:
            self.write_joint_dynamic_friction_coefficient_to_sim(joint_dynamic_friction_coeff, joint_ids, env_ids)
        if joint_viscous_friction_coeff is not None:
            self.write_joint_viscous_friction_coefficient_to_sim(joint_viscous_friction_coeff, joint_ids, env_ids)

    def write_joint_dynamic_friction_coefficient_to_sim(
        self,
        joint_dynamic_friction_coeff: torch.Tensor | float,
        joint_ids: JointIds = None,
        env_ids: EnvIds = None,
    ) -> None:
        """Take note that Isaac Lab's second dry friction is ignored: there is one."""
        note_ignored("write_joint_dynamic_friction_coefficient_to_sim", "one dry friction for each joint")

    def write_joint_viscous_friction_coefficient_to_sim(
        self,
        joint_viscous_friction_coeff: torch.Tensor | float,
        joint_ids: JointIds = None,
        env_ids: EnvIds = None,
    ) -> None:
        """Set efforts per joint velocity, shape (n, num joints chosen)."""
        self._set("joint_viscous_friction_coeff", joint_viscous_friction_coeff, joint_ids, env_ids, least=0.0)
        self._write_dofs("dof_damping", self.data.joint_viscous_friction_coeff)

    def _write_dofs(self, name: str, values: torch.Tensor) -> None:
        field = self._physics.randomizable(name)
        target = field if field.ndim == 2 else field[..., 0]
        target[:, self._dof_ids] = values.to(field.dtype)

    def write_joint_position_limit_to_sim(
        self,
        limits: torch.Tensor | float,
        joint_ids: JointIds = None,
        env_ids: EnvIds = None,
        warn_limit_violation: bool = True,
    ) -> None:
        """Set position limits (rad or m), shape (n, num joints chosen, 2).

        Soft limits follow, and defaults are clamped into them.

        Raises:
            ConfigError: a joint that has no limit in the model, or a lower limit above its upper one.
        """
        model = self._physics.model
        unlimited = [n for n, j in zip(self._joint_names, self._joint_ids, strict=True) if not model.jnt_limited[j]]
        for i in as_list(joint_ids, self.num_joints):
            name = self._joint_names[i]
            if name in unlimited:
                raise ConfigError(f"'{self.name}': joint '{name}' has no limit in its USD file, so none can be set")
        numbers = self._numbers(limits, "joint_pos_limits", tuple(self.data.joint_pos_limits.shape))
        pairs = numbers.ndim > 0 and numbers.shape[-1] == 2
        if pairs and numbers.is_cpu and not bool((numbers[..., 0] <= numbers[..., 1]).all()):
            raise ConfigError(f"'{self.name}'.joint_pos_limits: a lower limit is above its upper limit, or no number")
        self._set("joint_pos_limits", numbers, joint_ids, env_ids)
        field = self._physics.randomizable("jnt_range")
        field[:, self._joint_ids] = self.data.joint_pos_limits.to(field.dtype)
        self.data.soft_joint_pos_limits = self._soft(self.data.joint_pos_limits)
        low, high = self.data.joint_pos_limits.unbind(-1)
        self.data.default_joint_pos.clamp_(low, high)

    def write_joint_velocity_limit_to_sim(
        self, limits: torch.Tensor | float, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set velocity limits (rad/s or m/s), shape (n, num joints chosen), in ``data.joint_vel_limits``.

        MuJoCo does not clamp velocities. Rewards and resets read ``data.soft_joint_vel_limits``, which stay as they are
        (as in Isaac Lab).
        """
        self._set("joint_vel_limits", limits, joint_ids, env_ids, least=0.0, finite=False)

    def write_joint_effort_limit_to_sim(
        self, limits: torch.Tensor | float, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set effort limits of the engine's actuators, alike to both sides (N m or N), shape (n, num joints chosen).

        Raises:
            ConfigError: a joint whose actuator had no limit at start.
        """
        before = self.data.joint_effort_limits.clone()
        self._set("joint_effort_limits", limits, joint_ids, env_ids, least=0.0, finite=False)
        data, model = self.data, self._physics.model
        field = self._physics.randomizable("actuator_forcerange")
        for i in as_list(joint_ids, self.num_joints):
            name = self._joint_names[i]
            if name not in self._drives.joints:
                continue
            a = model.actuator(f"{self.name}/{name}").id
            rows = self._rows(env_ids)
            if not model.actuator_forcelimited[a]:
                if bool(data.joint_effort_limits[rows, i].isfinite().any()):
                    data.joint_effort_limits[:] = before
                    raise ConfigError(
                        f"'{self.name}': joint '{name}' has no effort limit that could be changed: set"
                        " effort_limit_sim of its actuator group"
                    )
                continue
            limit = data.joint_effort_limits[rows, i].clamp(max=NO_LIMIT).to(field.dtype)
            field[rows, a, 0] = -limit
            field[rows, a, 1] = limit
            if data.effort_range is not None:
                low, high = data.effort_range
                low[rows, i], high[rows, i] = -data.joint_effort_limits[rows, i], data.joint_effort_limits[rows, i]

    # Isaac Lab's older names
    write_joint_limits_to_sim = write_joint_position_limit_to_sim

    def write_joint_friction_to_sim(
        self, joint_friction: torch.Tensor | float, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set dry friction efforts: :meth:`write_joint_friction_coefficient_to_sim`."""
        self.write_joint_friction_coefficient_to_sim(joint_friction, joint_ids=joint_ids, env_ids=env_ids)

    # -- buffers

    def _set(
        self,
        name: str,
        value: torch.Tensor | float,
        joint_ids: JointIds,
        env_ids: EnvIds,
        least: float | None = None,
        finite: bool = True,
    ) -> None:
        """Write into a buffer of ``data``.

        Where ``least`` is given, no number may be below it or, if ``finite``, infinite; on a GPU this is not looked at.
        """
        buffer: torch.Tensor = getattr(self.data, name)
        ids = self._env_ids(env_ids)
        cols = slice(None) if joint_ids is None else joint_ids
        if not isinstance(cols, slice):
            cols = ids_tensor(cols, buffer.device, buffer.shape[1])
        index = (slice(None) if ids is None else ids, cols)
        if ids is not None and not isinstance(cols, slice):
            index = (ids[:, None], cols)
        numbers = self._numbers(value, name, tuple(buffer.shape))
        if least is not None:
            self._check_range(numbers, name, least, finite)
        try:
            buffer[index] = numbers
        except RuntimeError as error:
            wanted, given = tuple(buffer[index].shape), tuple(numbers.shape)
            raise ConfigError(f"'{self.name}'.{name}: values of shape {given} do not fit {wanted}") from error

    def _soft(self, limits: torch.Tensor) -> torch.Tensor:
        """Limits that are narrower by the config's factor, about the same middle."""
        middle = limits.mean(dim=-1)
        half = 0.5 * (limits[..., 1] - limits[..., 0]) * self.cfg.soft_joint_pos_limit_factor
        soft = torch.stack((middle - half, middle + half), dim=-1)
        return torch.where(limits.isfinite(), soft, limits)
