"""Base class of articulations and rigid objects: root pose, wrenches, masses and friction."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import mujoco
import torch

from lift_lab.sim.physics.base import ids_tensor
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError, PhysicsError
from lift_lab.utils.string import resolve_matching_names

from .asset_base import AssetBase, EnvIds, Values, as_columns, as_list
from .body_data import BodyData
from .physx_view import RigidBodyView

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics


class BodyAsset(AssetBase):
    """An asset with bodies whose state is simulated."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_body_names", "_geom_ids", "_ids", "_mocap", "_qadr", "_vadr", "_wrench_cols"}
    )

    _data: Any

    @property
    def data(self) -> BodyData:
        """The asset's state."""
        return self._data

    @property
    def engine_body_ids(self) -> list[int]:
        """Ids of the bodies in the compiled model."""
        return self._ids

    @property
    def engine_geom_ids(self) -> list[int]:
        """Ids of the bodies' geoms in the compiled model, body by body."""
        return self._geom_ids

    @property
    def num_bodies(self) -> int:
        """Number of bodies."""
        return len(self.body_names)

    @property
    def body_names(self) -> list[str]:
        """Names of the bodies; their order is that of all data and indices of bodies."""
        return self._body_names

    @property
    def is_fixed_base(self) -> bool:
        """Whether the root is fixed to the world."""
        return self._qadr is None

    @property
    def has_movable_root(self) -> bool:
        """Whether the root can be put elsewhere: it is free, or kinematic."""
        return self._qadr is not None or self._mocap is not None

    @cached_property
    def root_physx_view(self) -> RigidBodyView:
        """PhysX's tensor view, answered by MuJoCo."""
        return RigidBodyView(self)

    def find_bodies(self, name_keys: str | Sequence[str], preserve_order: bool = False) -> tuple[list[int], list[str]]:
        """Indices and names of the bodies that match regular expressions.

        Raises:
            ValueError: a pattern matches nothing, or a name matches two patterns.
        """
        return resolve_matching_names(name_keys, self.body_names, preserve_order)

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find bodies and the root joint in the compiled model (see :class:`AssetBase`)."""
        super().initialize(physics, env_origins_w)
        model = physics.model
        self._ids = self._body_ids()
        if not self._ids:
            raise ConfigError(f"scene.{self.name}: '{self.cfg.prim_path}' holds no rigid body; use AssetBaseCfg for it")
        self._body_names = [self._local_name(model.body(i).name) for i in self._ids]
        root = self._ids[0]
        joint = model.body_jntadr[root]
        free = joint >= 0 and int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_FREE)
        self._qadr = int(model.jnt_qposadr[joint]) if free else None
        self._vadr = int(model.jnt_dofadr[joint]) if free else None
        mocap = int(model.body_mocapid[root])
        self._mocap = mocap if mocap >= 0 else None
        place = {body: i for i, body in enumerate(self._ids)}
        geoms = [g for g in range(model.ngeom) if int(model.geom_bodyid[g]) in place]
        self._geom_ids = sorted(geoms, key=lambda g: place[int(model.geom_bodyid[g])])
        self._wrench_set = False
        self._force_b = torch.zeros(physics.num_envs, len(self._ids), 6, device=physics.device)
        self._wrench_cols = as_columns([6 * b + k for b in self._ids for k in range(6)], physics.device)
        self._make_data()
        self._data.entity_name = self.name
        state = self.cfg.init_state
        default = torch.tensor(
            [
                *state.pos,
                *state.rot,
                *getattr(state, "lin_vel", (0.0,) * 3),
                *getattr(state, "ang_vel", (0.0,) * 3),
            ],
            dtype=torch.float32,
            device=physics.device,
        )
        default[3:7] /= default[3:7].norm()
        if not self.has_movable_root:  # it stands where it stands, also if that is not the prim's origin
            default[:3] = torch.tensor(model.body_pos[root], dtype=torch.float32)
            default[3:7] = torch.tensor(model.body_quat[root], dtype=torch.float32)
        self._data.default_root_state[:] = default
        if not self.is_fixed_base:
            self.write_root_velocity_to_sim(self._data.default_root_state[:, 7:])

    @abstractmethod
    def _make_data(self) -> None:
        """Make :attr:`_data`, of the kind of asset's own class."""

    def update(self, dt: float) -> None:
        """Forget cached data: the engine's state has changed."""
        self._data.invalidate()

    def reset(self, env_ids: EnvIds = None) -> None:
        """Remove external wrenches of some environments."""
        if self._wrench_set:
            ids = self._env_ids(env_ids)
            self._force_b[slice(None) if ids is None else ids] = 0.0
            self._write_wrench()
            self._wrench_set = bool(self._force_b.any())

    def write_data_to_sim(self) -> None:
        """Send external wrenches to the engine."""
        if self._wrench_set:
            self._write_wrench()

    # -- root
    #
    # These take one row for each environment of env_ids, or one row or vector for all of them.

    def write_root_state_to_sim(self, root_state: Values, env_ids: EnvIds = None) -> None:
        """Set pose and centre-of-mass velocity of the root, shape (n, 13) or (13,), world frame.

        Raises:
            ConfigError: the shape does not fit; also of the other methods that write the root's state.
        """
        ids = self._env_ids(env_ids)
        state = self._fit(root_state, ids, (13,), "write_root_state_to_sim")
        self._write_root_pose(state[:, :7], ids)
        self._write_root_velocity(state[:, 7:], ids, at_com=True, quat=state[:, 3:7])

    def write_default_root_state_to_sim(self, env_ids: EnvIds = None) -> None:
        """Put the root of some environments into its default state, or of all."""
        ids = self._env_ids(env_ids)
        state = self._data.default_root_state if ids is None else self._data.default_root_state[ids]
        self._write_root_pose_in_env(state[:, :7], ids)
        self._write_root_velocity(state[:, 7:], ids, at_com=True, quat=state[:, 3:7])

    def write_root_pose_to_sim(self, root_pose: Values, env_ids: EnvIds = None) -> None:
        """Set the root's link pose; the velocity of its centre of mass in the world does not change.

        Args:
            root_pose: position (m) and orientation (w, x, y, z) in the world, shape (n, 7) or (7,).
            env_ids: environments, or None for all.

        Raises:
            ConfigError: the shape does not fit.
            PhysicsError: the root is fixed to the world elsewhere than where it is put.
        """
        ids = self._env_ids(env_ids)
        self._write_root_link_pose(self._fit(root_pose, ids, (7,), "write_root_pose_to_sim"), ids)

    def write_root_link_pose_to_sim(self, root_pose: Values, env_ids: EnvIds = None) -> None:
        """Isaac Lab's other name of :meth:`write_root_pose_to_sim`."""
        ids = self._env_ids(env_ids)
        self._write_root_link_pose(self._fit(root_pose, ids, (7,), "write_root_link_pose_to_sim"), ids)

    def _write_root_link_pose(self, pose: torch.Tensor, ids: torch.Tensor | None) -> None:
        """Set the root's link pose and keep the velocity of its centre of mass in the world."""
        if self._vadr is None:
            self._write_root_pose(pose, ids)
            return
        velocity = self._data.root_com_vel_w
        self._write_root_pose(pose, ids)
        self._write_root_velocity(velocity if ids is None else velocity[ids], ids, at_com=True, quat=pose[:, 3:7])

    def _write_root_pose(self, pose: torch.Tensor, ids: torch.Tensor | None) -> None:
        """Set the root's link pose; the rates of a free joint stay, which turn with the root."""
        origins_w = self._env_origins_w if ids is None else self._env_origins_w[ids]
        self._write_root_pose_in_env(torch.cat((pose[:, :3] - origins_w, pose[:, 3:7]), dim=-1), ids)

    def _write_root_pose_in_env(self, pose_e: torch.Tensor, ids: torch.Tensor | None) -> None:
        """As :meth:`_write_root_pose`, of positions in the environments' frames."""
        if self._qadr is not None:
            self._physics.write("qpos", pose_e, ids, slice(self._qadr, self._qadr + 7))
        elif self._mocap is not None:
            self._physics.write("mocap_pos", pose_e[:, :3], ids, slice(3 * self._mocap, 3 * self._mocap + 3))
            self._physics.write("mocap_quat", pose_e[:, 3:], ids, slice(4 * self._mocap, 4 * self._mocap + 4))
        else:
            self._check_fixed(pose_e[:, :3], pose_e[:, 3:])
        self._data.invalidate()

    def _check_fixed(self, pos_e: torch.Tensor, quat: torch.Tensor) -> None:
        """A root that is fixed to the world can only be put where it stands; on a GPU this is not looked at."""
        if self._physics.device.type != "cpu":
            return
        model = self._physics.model
        home = torch.tensor(model.body_pos[self._ids[0]], dtype=pos_e.dtype)
        turned = (quat @ torch.tensor(model.body_quat[self._ids[0]], dtype=quat.dtype)).abs()
        if (pos_e - home).abs().max() > 1e-3 or turned.min() < 1.0 - 1e-4:
            raise PhysicsError(
                f"'{self.name}' is fixed to the world and can be neither moved nor turned; free it with "
                "articulation_props.fix_root_link=False, or make it kinematic"
            )

    def write_root_velocity_to_sim(self, root_velocity: Values, env_ids: EnvIds = None) -> None:
        """Set the velocity of the root's centre of mass in the world.

        Args:
            root_velocity: linear (m/s) then angular (rad/s), shape (n, 6) or (6,), or one number for all six.
            env_ids: environments, or None for all.
        """
        self._set_root_velocity(root_velocity, env_ids, "write_root_velocity_to_sim", at_com=True)

    def write_root_com_velocity_to_sim(self, root_velocity: Values, env_ids: EnvIds = None) -> None:
        """Isaac Lab's other name of :meth:`write_root_velocity_to_sim`."""
        self._set_root_velocity(root_velocity, env_ids, "write_root_com_velocity_to_sim", at_com=True)

    def write_root_link_velocity_to_sim(self, root_velocity: Values, env_ids: EnvIds = None) -> None:
        """Set the velocity of the root's origin; arguments as those of :meth:`write_root_velocity_to_sim`."""
        self._set_root_velocity(root_velocity, env_ids, "write_root_link_velocity_to_sim", at_com=False)

    def _set_root_velocity(self, velocity: Values, env_ids: EnvIds, method: str, at_com: bool) -> None:
        ids = self._env_ids(env_ids)
        self._write_root_velocity(self._fit(velocity, ids, (6,), method, any_width=True), ids, at_com=at_com)

    def write_root_link_state_to_sim(self, root_state: Values, env_ids: EnvIds = None) -> None:
        """Set pose and link velocity of the root, shape (n, 13) or (13,), world frame."""
        ids = self._env_ids(env_ids)
        state = self._fit(root_state, ids, (13,), "write_root_link_state_to_sim")
        self._write_root_pose(state[:, :7], ids)
        self._write_root_velocity(state[:, 7:], ids, at_com=False)

    def write_root_com_pose_to_sim(self, root_pose: Values, env_ids: EnvIds = None) -> None:
        """Put the root where its principal inertia frame gets a pose, shape (n, 7) or (7,), world frame."""
        ids = self._env_ids(env_ids)
        self._write_root_com_pose(self._fit(root_pose, ids, (7,), "write_root_com_pose_to_sim"), ids)

    def _write_root_com_pose(self, pose: torch.Tensor, ids: torch.Tensor | None) -> None:
        rows = slice(None) if ids is None else ids
        com_pos_b, com_quat_b = self._data.body_com_pos_b[rows, 0], self._data.body_com_quat_b[rows, 0]
        quat_w = math_utils.quat_mul(pose[:, 3:7], math_utils.quat_inv(com_quat_b))
        pos_w = pose[:, :3] - math_utils.quat_apply(quat_w, com_pos_b)
        self._write_root_link_pose(torch.cat((pos_w, quat_w), dim=-1), ids)

    def write_root_com_state_to_sim(self, root_state: Values, env_ids: EnvIds = None) -> None:
        """Set centre-of-mass pose and velocity of the root, shape (n, 13) or (13,), world frame."""
        ids = self._env_ids(env_ids)
        state = self._fit(root_state, ids, (13,), "write_root_com_state_to_sim")
        self._write_root_com_pose(state[:, :7], ids)
        self._write_root_velocity(state[:, 7:], ids, at_com=True)

    def _write_root_velocity(
        self, vel_w: torch.Tensor, ids: torch.Tensor | None, at_com: bool, quat: torch.Tensor | None = None
    ) -> None:
        """Write a velocity of the centre of mass or of the origin; ``quat`` is the root's orientation, if known."""
        if self._vadr is None or self._qadr is None:
            return
        if quat is None:
            qpos = self._physics.field("qpos")
            quat = (qpos if ids is None else qpos[ids])[:, self._qadr + 3 : self._qadr + 7]
        qvel, ang = vel_w, vel_w[:, 3:]
        if self._physics.device.type != "cpu" or bool(ang.any()):  # on a GPU the question would cost more than it saves
            lin = vel_w[:, :3]
            if at_com and not self.data.root_com_is_origin:
                com_b = self.data.body_com_pos_b[:, 0]
                arm_w = math_utils.quat_apply(quat, com_b if ids is None else com_b[ids])
                lin = lin - torch.linalg.cross(ang, arm_w)
            qvel = torch.cat((lin, math_utils.quat_apply_inverse(quat, ang)), dim=-1)
        self._physics.write("qvel", qvel, ids, slice(self._vadr, self._vadr + 6))
        self._data.invalidate()

    # -- wrenches

    @property
    def external_wrench_b(self) -> torch.Tensor:
        """External forces in N and torques in N m about the centres of mass, in the bodies' link frames.

        Shape (num_envs, num_bodies, 6), force first. Read it only: :meth:`set_external_force_and_torque` writes it.
        """
        return self._force_b

    def set_external_force_and_torque(
        self,
        forces: Values,
        torques: Values,
        positions: Values | None = None,
        body_ids: Sequence[int] | slice | None = None,
        env_ids: EnvIds = None,
        is_global: bool = False,
    ) -> None:
        """Set wrenches on bodies; they act until changed, turned with their body once an environment step.

        Args:
            forces: in N, shape (n, num bodies chosen, 3), or what broadcasts to that. Empty tensors of forces and
                torques take all wrenches off.
            torques: in N m, same shape.
            positions: where the forces act in m, same shape; None for the centres of mass.
            body_ids: bodies, or None for all.
            env_ids: environments, or None for all.
            is_global: whether forces, torques and positions are in the world frame; else in each body's link frame.

        Raises:
            ConfigError: a shape does not fit.
        """
        shape, method = (self.num_bodies, 3), "set_external_force_and_torque"
        force_b, torque_b = (self._numbers(vector, method, shape) for vector in (forces, torques))
        if not force_b.numel() and not torque_b.numel():
            self._force_b.zero_()
            self._wrench_set = True  # so that the next write sends the zeros
            return
        ids = self._env_ids(env_ids)
        rows = slice(None) if ids is None else ids
        chosen = slice(None) if body_ids is None else body_ids
        if not isinstance(chosen, slice):
            chosen = ids_tensor(chosen, self._force_b.device, self.num_bodies).reshape(-1)
        count = len(range(*chosen.indices(self.num_bodies))) if isinstance(chosen, slice) else len(chosen)
        shape = (count, 3)
        force_b, torque_b = (self._fit(vector, ids, shape, method) for vector in (force_b, torque_b))
        if positions is not None:
            positions = self._fit(positions, ids, shape, method)
        if is_global:
            quat = self._data.body_link_quat_w[rows][:, chosen]
            force_b, torque_b = (math_utils.quat_apply_inverse(quat, vector) for vector in (force_b, torque_b))
            if positions is not None:
                positions = math_utils.quat_apply_inverse(quat, positions - self._data.body_link_pos_w[rows][:, chosen])
        if positions is not None:
            arm = positions - self._data.body_com_pos_b[rows][:, chosen]
            torque_b = torque_b + torch.linalg.cross(arm, force_b)
        wrench = torch.cat((force_b, torque_b), dim=-1)
        if ids is None or isinstance(chosen, slice):
            self._force_b[rows, chosen] = wrench
        else:
            self._force_b[ids[:, None], chosen] = wrench
        self._wrench_set = True

    def _write_wrench(self) -> None:
        quat = self._data.body_link_quat_w
        force_w = math_utils.quat_apply(quat, self._force_b[..., :3].contiguous())
        torque_w = math_utils.quat_apply(quat, self._force_b[..., 3:].contiguous())
        wrench = torch.cat((force_w, torque_w), dim=-1).flatten(1)
        self._physics.write("xfrc_applied", wrench, None, self._wrench_cols)

    # -- model fields of each environment

    def get_masses(self) -> torch.Tensor:
        """Current masses in kg, shape (num_envs, num_bodies)."""
        return self._physics.randomizable("body_mass")[:, self._ids].float()

    def write_body_mass_to_sim(
        self,
        masses: torch.Tensor,
        body_ids: Sequence[int] | torch.Tensor | None = None,
        env_ids: EnvIds = None,
        recompute_inertia: bool = True,
    ) -> None:
        """Set masses of bodies.

        Args:
            masses: in kg, shape (n, num bodies chosen), or what broadcasts to that.
            body_ids: bodies, or None for all.
            env_ids: environments, or None for all.
            recompute_inertia: whether inertias scale with the mass (relative to their defaults).

        Raises:
            ConfigError: a mass that is not positive, or a shape that does not fit.
        """
        rows = self._rows(env_ids)
        chosen = as_list(body_ids, self.num_bodies)
        masses = self._fit(masses, rows, (len(chosen),), "write_body_mass_to_sim", any_width=True)
        self._check_masses(masses)
        cols = torch.tensor([self._ids[b] for b in chosen], device=rows.device)
        mass = self._physics.randomizable("body_mass")
        mass[rows[:, None], cols] = masses.to(mass.dtype)
        if recompute_inertia:
            inertia = self._physics.randomizable("body_inertia")
            default_mass = self._data.default_mass[rows][:, chosen]
            ratio = torch.where(default_mass > 0, masses / default_mass, 1.0)  # nothing scales from nothing
            value = self.data.default_principal_inertia[rows][:, chosen] * ratio[..., None]
            inertia[rows[:, None], cols] = value.to(inertia.dtype)
        self._physics.recompute_constants()

    def write_body_com_to_sim(
        self,
        coms_b: torch.Tensor,
        body_ids: Sequence[int] | torch.Tensor | None = None,
        env_ids: EnvIds = None,
    ) -> None:
        """Set centres of mass; inertias stay as they are about them.

        Args:
            coms_b: in m, in the link frames, shape (n, num bodies chosen, 3), or what broadcasts to that.
            body_ids: bodies, or None for all.
            env_ids: environments, or None for all.

        Raises:
            ConfigError: a free body that was compiled for a centre of mass at its origin, or a shape that does not fit.
        """
        rows = self._rows(env_ids)
        chosen = as_list(body_ids, self.num_bodies)
        coms_b = self._fit(coms_b, rows, (len(chosen), 3), "write_body_com_to_sim")
        self._check_range(coms_b, "write_body_com_to_sim", -torch.inf)
        for b in chosen:
            if self._physics.model.body_simple[self._ids[b]]:
                raise ConfigError(
                    f"'{self.name}': the centre of mass of '{self._body_names[b]}' was compiled to stay at its origin;"
                    " move it by an event term mdp.randomize_rigid_body_com of the environment's config"
                )
        cols = torch.tensor([self._ids[b] for b in chosen], device=rows.device)
        field = self._physics.randomizable("body_ipos")
        field[rows[:, None], cols] = coms_b.to(field.dtype)
        self._physics.recompute_constants()
        self.data.set_body_com(rows, torch.tensor(chosen, device=rows.device), coms_b)

    def write_collider_margin_to_sim(
        self, margin: Values, body_ids: Sequence[int] | None = None, env_ids: EnvIds = None
    ) -> None:
        """Set the contact margin of all colliders of some bodies: how far from its surface a collider is felt.

        Args:
            margin: in m, shape (n,) or (n, 1), or one number.
            body_ids: bodies, or None for all.
            env_ids: environments, or None for all.
        """
        self._write_geoms("geom_margin", margin, "write_collider_margin_to_sim", body_ids, env_ids)

    def write_friction_to_sim(
        self, friction: Values, body_ids: Sequence[int] | None = None, env_ids: EnvIds = None
    ) -> None:
        """Set the sliding friction of all colliders of some bodies.

        Args:
            friction: coefficient, at least 0, shape (n,) or (n, 1), or one number.
            body_ids: bodies, or None for all.
            env_ids: environments, or None for all.
        """
        self._write_geoms("geom_friction", friction, "write_friction_to_sim", body_ids, env_ids, least=0.0)

    def _write_geoms(
        self,
        name: str,
        values: Values,
        method: str,
        body_ids: Sequence[int] | None,
        env_ids: EnvIds,
        least: float = -torch.inf,
    ) -> None:
        """Write a number for each environment into a field of the bodies' colliders (the first of several columns)."""
        rows = self._rows(env_ids)
        values = self._numbers(values, method, (len(rows), 1))
        if values.numel() not in (1, len(rows)):
            shape = tuple(values.shape)
            raise ConfigError(f"'{self.name}'.{method}: values of shape {shape} do not fit {(len(rows), 1)}")
        self._check_range(values, method, least)
        model = self._physics.model
        wanted = {self._ids[b] for b in as_list(body_ids, self.num_bodies)}
        geoms = [g for g in self._geom_ids if model.geom_bodyid[g] in wanted]
        field = self._physics.randomizable(name)
        target = field if field.ndim == 2 else field[..., 0]
        cols = torch.tensor(geoms, dtype=torch.long, device=rows.device)
        target[rows[:, None], cols] = values.reshape(-1, 1).to(field.dtype)
