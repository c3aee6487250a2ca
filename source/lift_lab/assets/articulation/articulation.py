"""An articulation."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import mujoco
import torch

from lift_lab.actuators import ActuatorBase
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.string import resolve_matching_names, resolve_matching_names_values
from lift_lab.utils.types import ArticulationActions

from ..asset_base import EnvIds, Values, as_columns, as_list
from .articulation_data import ArticulationData
from .articulation_view import ArticulationView
from .drives import build_drives
from .file_drives import FileDrive
from .index_order import IndexOrder, breadth_first_order, check_index_order
from .joint_properties import JointIds, JointProperties

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

    from .articulation_cfg import ArticulationCfg

logger = logging.getLogger(__name__)


class Articulation(JointProperties):
    """Bodies connected by joints, with actuators that follow targets set by the user.

    Joints and bodies are numbered as in Isaac Lab: breadth first, children in the order of their joints on the USD
    stage, the root first. Names, data, targets, actions, indices and ``root_physx_view`` have this order; the engine's
    own stays inside. ``cfg.index_order="engine"`` selects that one instead.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_all_implicit", "_computed", "_ctrl_cols", "_dof_ids", "_driven", "_drives", "_implicit"}
        | {"_joint_ids", "_joint_names", "_order", "_qpos_ids"}
    )

    cfg: ArticulationCfg

    @cached_property
    def root_physx_view(self) -> ArticulationView:
        """PhysX's tensor view, answered by MuJoCo."""
        return ArticulationView(self)

    @property
    def joint_names(self) -> list[str]:
        """Names of the joints; their order is that of all data and indices of joints."""
        return self._joint_names

    @property
    def has_explicit_actuators(self) -> bool:
        """Whether an actuator model has to be computed before each physics step."""
        return bool(self._computed)

    def find_joints(
        self,
        name_keys: str | Sequence[str],
        joint_subset: list[str] | None = None,
        preserve_order: bool = False,
    ) -> tuple[list[int], list[str]]:
        """Indices and names of the joints that match regular expressions.

        With a ``joint_subset``, indices are into the subset (as in Isaac Lab).

        Raises:
            ValueError: a pattern matches nothing, or a name matches two patterns.
        """
        return resolve_matching_names(name_keys, joint_subset or self.joint_names, preserve_order)

    # -- building

    def _edit_spec(self, spec: mujoco.MjSpec) -> None:
        report = self.spawned.report if self.spawned is not None else None
        check_index_order(self.cfg.index_order, f"scene.{self.name}.index_order")
        self._order = IndexOrder() if self.cfg.index_order == "engine" else breadth_first_order(spec, report)
        self._drives = build_drives(spec, self.cfg.actuators, report, f"scene.{self.name}")

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find joints and actuators in the compiled model and resolve defaults and limits.

        Raises:
            ConfigError: a default joint position outside its limits, or a name pattern that matches no joint.
        """
        super().initialize(physics, env_origins_w)
        device, num_envs, data = physics.device, physics.num_envs, self.data
        model = physics.model

        def per_env(values: list[float]) -> torch.Tensor:
            return torch.tensor(values, dtype=torch.float32, device=device).repeat(num_envs, 1)

        drives = [self._drives.joints.get(name) for name in self._joint_names]
        data.joint_names = self._joint_names
        data.joint_stiffness = per_env([d.stiffness if d else 0.0 for d in drives])
        data.joint_damping = per_env([d.damping if d else 0.0 for d in drives])
        data.joint_effort_limits = per_env([d.effort_limit if d else float("inf") for d in drives])
        data.joint_vel_limits = per_env([d.file.velocity_limit if d else float("inf") for d in drives])
        data.soft_joint_vel_limits = data.joint_vel_limits.clone()
        data.joint_armature = per_env(model.dof_armature[self._dof_ids].tolist())
        data.joint_friction_coeff = per_env(model.dof_frictionloss[self._dof_ids].tolist())
        damping = model.dof_damping[self._dof_ids]
        data.joint_viscous_friction_coeff = per_env((damping if damping.ndim == 1 else damping[:, 0]).tolist())
        data.gear_ratio = torch.ones(num_envs, self.num_joints, device=device)
        self._resolve_limits(model, device, num_envs)
        self._resolve_defaults(per_env)
        self._make_actuators(device, per_env)
        data.default_joint_stiffness = data.joint_stiffness.clone()
        data.default_joint_damping = data.joint_damping.clone()
        data.default_joint_armature = data.joint_armature.clone()
        data.default_joint_friction_coeff = data.joint_friction_coeff.clone()
        data.default_joint_viscous_friction_coeff = data.joint_viscous_friction_coeff.clone()
        self._write_initial_state()

    def _body_ids(self) -> list[int]:
        model = self._physics.model
        return sorted(super()._body_ids(), key=lambda i: self._order.body(self._local_name(model.body(i).name)))

    @property
    def stage_paths(self) -> dict[str, str] | None:
        """Path of each body below the asset's prim, in the order of the stage; None with the engine's order."""
        return self._order.stage_paths

    def _make_data(self) -> None:
        model = self._physics.model
        ids = set(self._ids)
        scalar = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
        joints = [j for j in range(model.njnt) if model.jnt_bodyid[j] in ids and int(model.jnt_type[j]) in scalar]
        joints.sort(key=lambda j: self._order.joint(self._local_name(model.joint(j).name)))
        self._joint_ids = joints
        self._joint_names = [self._local_name(model.joint(j).name) for j in joints]
        self._dof_ids = [int(model.jnt_dofadr[j]) for j in joints]
        self._qpos_ids = [int(model.jnt_qposadr[j]) for j in joints]
        device = self._physics.device
        self._qpos_cols, self._dof_cols = as_columns(self._qpos_ids, device), as_columns(self._dof_ids, device)
        self._data = ArticulationData(
            self._physics,
            self._env_origins_w,
            self._ids,
            self._body_names,
            self._qadr,
            self._vadr,
            self._mocap,
            qpos_cols=self._qpos_cols,
            dof_cols=self._dof_cols,
        )

    def _resolve_limits(self, model: mujoco.MjModel, device: torch.device, num_envs: int) -> None:
        limits = torch.tensor(model.jnt_range[self._joint_ids], dtype=torch.float32, device=device)
        limits[~torch.tensor(model.jnt_limited[self._joint_ids], dtype=torch.bool, device=device)] = torch.tensor(
            [-float("inf"), float("inf")], device=device
        )
        data = self.data
        data.joint_pos_limits = limits.repeat(num_envs, 1, 1)
        data.default_joint_pos_limits = data.joint_pos_limits.clone()
        data.soft_joint_pos_limits = self._soft(data.joint_pos_limits)

    def _resolve_defaults(self, per_env) -> None:
        data = self.data
        for kind in ("joint_pos", "joint_vel"):
            path = f"scene.{self.name}.init_state.{kind}"
            values = [0.0] * self.num_joints
            try:
                ids, _, found = resolve_matching_names_values(getattr(self.cfg.init_state, kind), self.joint_names)
            except ValueError as error:
                if not self.joint_names:
                    ids, found = [], []
                else:
                    raise ConfigError(f"{path}: {error}") from error
            for i, value in zip(ids, found, strict=True):
                values[i] = value
            setattr(data, f"default_{kind}", per_env(values))
        if not self.num_joints:
            return
        pos, limits = data.default_joint_pos[0], data.joint_pos_limits[0]
        for i in ((pos < limits[:, 0] - 1e-5) | (pos > limits[:, 1] + 1e-5)).nonzero().flatten().tolist():
            raise ConfigError(
                f"scene.{self.name}.init_state.joint_pos: {pos[i]:.4f} of '{self.joint_names[i]}' is outside its "
                f"limits [{limits[i, 0]:.4f}, {limits[i, 1]:.4f}]"
            )

    def _make_actuators(self, device: torch.device, per_env: Callable[[list[float]], torch.Tensor]) -> None:
        data, names, drives = self.data, self._joint_names, self._drives.joints
        self.actuators: dict[str, ActuatorBase] = {}
        for group, joints in self._drives.groups.items():
            cfg = self.cfg.actuators[group]
            joints = sorted(joints, key=names.index)
            files = [drives[joint].file for joint in joints]
            self.actuators[group] = cfg.class_type(
                cfg=cfg,
                joint_names=joints,
                joint_ids=torch.tensor([names.index(joint) for joint in joints], device=device),
                num_envs=self.num_instances,
                device=str(device),
                stiffness=per_env([file.drive.stiffness for file in files]),
                damping=per_env([file.drive.damping for file in files]),
                armature=per_env([file.armature for file in files]),
                friction=per_env([file.friction for file in files]),
                viscous_friction=per_env([file.viscous_friction for file in files]),
                effort_limit=per_env([file.drive.effort_limit for file in files]),
                velocity_limit=per_env([file.velocity_limit for file in files]),
            )
        driven = [name for name in names if name in drives]
        self._driven = as_columns([names.index(name) for name in driven], device)
        model = self._physics.model
        columns = [int(model.actuator_ctrladr[model.actuator(f"{self.name}/{name}").id]) for name in driven]
        self._ctrl_cols = as_columns(columns, device)
        self._implicit = torch.tensor([drives[name].implicit for name in driven], device=device)
        self._all_implicit = bool(self._implicit.all())
        self._computed = [actuator for actuator in self.actuators.values() if not actuator.runs_in_engine]
        computed = [names.index(name) for actuator in self._computed for name in actuator.joint_names]
        if computed:
            data.explicit_ids = torch.tensor(sorted(computed), device=device)
        # a drive without stiffness takes an effort: then the law has to be written out, too
        self._has_feedforward = any(drive.implicit and not drive.stiffness for drive in drives.values())
        self._read_file_laws(per_env)
        for actuator in self.actuators.values():
            self._take_over(actuator)
        self._report_resolution()

    def _read_file_laws(self, per_env: Callable[[list[float]], torch.Tensor]) -> None:
        """What the file's drives have beside two gains: constant efforts, ranges of targets, lopsided efforts."""
        data, drives = self.data, [self._drives.joints.get(name) for name in self._joint_names]
        laws = [drive.law if drive is not None and drive.law is not None else FileDrive() for drive in drives]
        if any(law.constant for law in laws):
            data.constant_effort = per_env([law.constant for law in laws])
        ranges = [d.effort_range if d is not None else FileDrive().effort_range for d in drives]
        if any(low != -high for low, high in ranges):
            data.effort_range = per_env([low for low, _ in ranges]), per_env([high for _, high in ranges])
        implicit = [law if d is not None and d.implicit else FileDrive() for d, law in zip(drives, laws, strict=True)]
        for kind in ("position", "velocity"):
            ends = [getattr(law, f"{kind}_range") for law in implicit]
            if any(end != FileDrive().position_range for end in ends):
                data.target_ranges[kind] = per_env([low for low, _ in ends]), per_env([high for _, high in ends])

    def _take_over(self, actuator: ActuatorBase) -> None:
        """Report what an actuator resolved its config to, and give the engine what differs from the compiled model."""
        data, ids = self.data, actuator.joint_indices
        chosen = torch.arange(self.num_joints, device=self._physics.device)[ids]
        for value, current, write in (
            (actuator.stiffness, data.joint_stiffness, self.write_joint_stiffness_to_sim),
            (actuator.damping, data.joint_damping, self.write_joint_damping_to_sim),
            (actuator.effort_limit_sim, data.joint_effort_limits, self.write_joint_effort_limit_to_sim),
            (actuator.armature, data.joint_armature, self.write_joint_armature_to_sim),
            (actuator.friction, data.joint_friction_coeff, self.write_joint_friction_coefficient_to_sim),
            (
                actuator.viscous_friction,
                data.joint_viscous_friction_coeff,
                self.write_joint_viscous_friction_coefficient_to_sim,
            ),
        ):
            if not torch.equal(value, current[:, chosen]):
                write(value.clone(), joint_ids=chosen)
        data.joint_vel_limits[:, chosen] = actuator.velocity_limit_sim
        data.soft_joint_vel_limits[:, chosen] = actuator.velocity_limit
        data.gear_ratio[:, chosen] = actuator.gear_ratio

    def _report_resolution(self) -> None:
        """Log which values came from where, if the config asks for it."""
        if not self.cfg.actuator_value_resolution_debug_print:
            return
        for group, actuator in self.actuators.items():
            for name, rows in actuator.joint_property_resolution_table.items():
                for joint, _, of_file, given, used in rows:
                    values = [v if isinstance(v, str) else f"{v:g}" for v in (of_file, given, used)]
                    where = f"scene.{self.name}.actuators['{group}'].{name} of '{joint}'"
                    logger.warning("%s: file %s, config %s, used %s", where, *values)

    def _write_initial_state(self) -> None:
        data = self.data
        data.joint_pos_target = data.default_joint_pos.clone()
        data.joint_vel_target = torch.zeros_like(data.default_joint_vel)
        data.joint_effort_target = torch.zeros_like(data.default_joint_vel)
        if self.num_joints:
            self.write_joint_state_to_sim(data.default_joint_pos, data.default_joint_vel)
        self.write_data_to_sim()

    # -- stepping

    def reset(self, env_ids: EnvIds = None) -> None:
        """Put targets of some environments back to their defaults and remove external wrenches."""
        super().reset(env_ids)
        ids = self._env_ids(env_ids)
        rows = slice(None) if ids is None else ids
        data = self.data
        data.joint_pos_target[rows] = data.default_joint_pos[rows]
        if self._has_feedforward:  # else they are zero
            data.joint_vel_target[rows] = 0.0
            data.joint_effort_target[rows] = 0.0
        for actuator in self.actuators.values():
            actuator.reset(ids)

    def start_episodes(self, env_ids: torch.Tensor) -> None:
        """Let explicit actuators of these environments (a LongTensor) alone start from the targets a reset left."""
        data = self.data
        if data.explicit_effort is None or data.explicit_computed is None:
            return
        data.explicit_effort = data.explicit_effort.index_fill(0, env_ids, 0.0)
        data.explicit_computed = data.explicit_computed.index_fill(0, env_ids, 0.0)
        for actuator in self._computed:
            actuator.start_episodes(env_ids, self._targets(actuator, env_ids))

    def _targets(self, actuator: ActuatorBase, env_ids: torch.Tensor | slice = slice(None)) -> ArticulationActions:
        """Targets of an actuator's joints in some environments."""
        data, ids = self.data, actuator.joint_indices
        efforts = data.joint_effort_target[env_ids][:, ids]
        if data.constant_effort is not None and not actuator.is_implicit_model:  # else the engine adds it
            efforts = efforts + data.constant_effort[env_ids][:, ids]
        return ArticulationActions(
            joint_positions=data.joint_pos_target[env_ids][:, ids],
            joint_velocities=data.joint_vel_target[env_ids][:, ids],
            joint_efforts=efforts,
            joint_indices=ids,
        )

    def write_data_to_sim(self) -> None:
        """Send targets (and external wrenches) to the engine; explicit actuator models are computed here."""
        super().write_data_to_sim()
        data = self.data
        if not self._drives.joints:
            return
        position, velocity, effort = data.joint_pos_target, data.joint_vel_target, data.joint_effort_target
        explicit = None
        if self._computed:
            position, velocity, effort, explicit = self._compute_actuators()
        ctrl = data.clip_target("position", position)[:, self._driven]
        if self._has_feedforward:
            velocity = data.clip_target("velocity", velocity)
            ctrl = self._feedforward_ctrl(ctrl, velocity[:, self._driven], effort[:, self._driven])
        if not self._all_implicit:
            assert explicit is not None
            ctrl = torch.where(self._implicit, ctrl, explicit[:, self._driven])
        self._physics.write("ctrl", ctrl, None, self._ctrl_cols)

    def _feedforward_ctrl(self, position: torch.Tensor, velocity: torch.Tensor, effort: torch.Tensor) -> torch.Tensor:
        """Control that makes the engine's kp (ctrl - q) - kd qd equal the full PD law with feed-forward."""
        data, cols = self.data, self._driven
        kp, kd = data.joint_stiffness[:, cols], data.joint_damping[:, cols]
        extra = kd * velocity + effort
        stiff = kp > 0
        return torch.where(stiff, position + extra / torch.where(stiff, kp, torch.ones_like(kp)), extra)

    def _compute_actuators(self) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor]:
        """Targets for the engine's own drives, and efforts of the explicit models, of all joints.

        Raises:
            ConfigError: a model returns no effort, or an implicit one no target.
        """
        data = self.data
        given = torch.zeros_like(data.joint_pos_target)
        computed = torch.zeros_like(given)
        targets = {"position": data.joint_pos_target, "velocity": data.joint_vel_target}
        targets["effort"] = data.joint_effort_target
        copied = False
        for actuator in self._computed:
            ids = actuator.joint_indices
            action = actuator.compute(self._targets(actuator), data.joint_pos[:, ids], data.joint_vel[:, ids])
            efforts = action.joint_efforts
            if not actuator.is_implicit_model:
                if efforts is None:
                    raise ConfigError(f"{type(actuator).__name__}.compute must return joint_efforts")
                given[:, ids] = efforts
            else:
                if not copied:
                    targets, copied = {kind: target.clone() for kind, target in targets.items()}, True
                    self._has_feedforward = True
                values = action.joint_positions, action.joint_velocities, efforts
                for kind, value in zip(targets, values, strict=True):
                    if value is None:
                        raise ConfigError(
                            f"{type(actuator).__name__}.compute must return joint_positions,"
                            " joint_velocities and joint_efforts"
                        )
                    targets[kind][:, ids] = value
                given[:, ids] = actuator.applied_effort
            computed[:, ids] = actuator.computed_effort
        data.explicit_effort = given[:, data.explicit_ids]
        data.explicit_computed = computed[:, data.explicit_ids]
        return targets["position"], targets["velocity"], targets["effort"], given

    # -- targets

    def set_joint_position_target(
        self, target: torch.Tensor, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set position targets (rad or m), shape (n, num joints chosen)."""
        self._set("joint_pos_target", target, joint_ids, env_ids)

    def set_joint_velocity_target(
        self, target: torch.Tensor, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set velocity targets (rad/s or m/s), shape (n, num joints chosen)."""
        self._has_feedforward = True
        self._set("joint_vel_target", target, joint_ids, env_ids)

    def set_joint_effort_target(self, target: torch.Tensor, joint_ids: JointIds = None, env_ids: EnvIds = None) -> None:
        """Set feed-forward efforts (N m or N), shape (n, num joints chosen)."""
        self._has_feedforward = True
        self._set("joint_effort_target", target, joint_ids, env_ids)

    # -- joint state

    def write_joint_state_to_sim(
        self, position: Values, velocity: Values, joint_ids: JointIds = None, env_ids: EnvIds = None
    ) -> None:
        """Set joint positions and velocities, shape (n, num joints chosen), or what broadcasts to that.

        Raises:
            ConfigError: a shape does not fit; nothing is written then.
        """
        ids = self._env_ids(env_ids)
        position = self._fit_joints(position, joint_ids, ids, "write_joint_state_to_sim")
        velocity = self._fit_joints(velocity, joint_ids, ids, "write_joint_state_to_sim")
        self._write_joints("qpos", position, joint_ids, ids)
        self._write_joints("qvel", velocity, joint_ids, ids)

    def write_joint_position_to_sim(self, position: Values, joint_ids: JointIds = None, env_ids: EnvIds = None) -> None:
        """Set joint positions (rad or m), shape (n, num joints chosen), or what broadcasts to that.

        Raises:
            ConfigError: the shape does not fit.
        """
        ids = self._env_ids(env_ids)
        position = self._fit_joints(position, joint_ids, ids, "write_joint_position_to_sim")
        self._write_joints("qpos", position, joint_ids, ids)

    def write_joint_velocity_to_sim(self, velocity: Values, joint_ids: JointIds = None, env_ids: EnvIds = None) -> None:
        """Set joint velocities (rad/s or m/s), shape (n, num joints chosen), or what broadcasts to that.

        Raises:
            ConfigError: the shape does not fit.
        """
        ids = self._env_ids(env_ids)
        velocity = self._fit_joints(velocity, joint_ids, ids, "write_joint_velocity_to_sim")
        self._write_joints("qvel", velocity, joint_ids, ids)

    def _fit_joints(self, values: Values, joint_ids: JointIds, ids: torch.Tensor | None, method: str) -> torch.Tensor:
        count = self.num_joints if joint_ids is None else len(as_list(joint_ids, self.num_joints))
        return self._fit(values, ids, (count,), method, any_width=True)

    def _write_joints(self, name: str, values: torch.Tensor, joint_ids: JointIds, ids: torch.Tensor | None) -> None:
        data = self.data
        of_pos = name == "qpos"
        all_ids, all_cols = (self._qpos_ids, self._qpos_cols) if of_pos else (self._dof_ids, self._dof_cols)
        self._physics.write(name, values, ids, self._columns(all_ids, all_cols, joint_ids))
        data.invalidate()

    def _columns(self, all_ids: list[int], all_cols: slice | torch.Tensor, joint_ids: JointIds) -> slice | torch.Tensor:
        """Where the engine keeps something of some joints, given where it keeps it of all."""
        if joint_ids is None or (isinstance(joint_ids, slice) and joint_ids == slice(None)):
            return all_cols
        return as_columns([all_ids[i] for i in as_list(joint_ids, self.num_joints)], self._physics.device)

    # -- kinematics

    def get_jacobians(self, body_idx: int) -> torch.Tensor:
        """Jacobian of a body's origin in the world, rows linear then angular, shape (num_envs, 6, num_joints)."""
        return self._physics.jac_body(self._ids[body_idx])[:, :, self._dof_ids]
