"""A deformable object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import mujoco
import numpy as np
import torch

from lift_lab.sim import SimulationContext, note_ignored
from lift_lab.sim.schemas import DeformableBodyPropertiesCfg
from lift_lab.sim.spawners.appearance import linear_to_srgb
from lift_lab.sim.spawners.file_options import adopt_scene_options
from lift_lab.sim.spawners.materials import PreviewSurfaceCfg
from lift_lab.usd.deformable import SoftBody, add_flex
from lift_lab.utils import math as math_utils
from lift_lab.utils.errors import ConfigError

from ..asset_base import AssetBase, EnvIds, Values, as_columns
from .deformable_object_data import DeformableObjectData

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

    from .deformable_object_cfg import DeformableObjectCfg

INTEGRATOR = "discrete"
"""MuJoCo's only integrator that is stable with soft bodies at useful time steps."""


class DeformableObject(AssetBase):
    """One soft body: a MuJoCo flex of one cell with eight nodes (see :mod:`lift_lab.usd.deformable`).

    It has nodal positions and velocities and no orientation; its root is the mean of its nodes, as in Isaac Lab.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_flex", "_nodes", "_qpos", "_qvel"})

    cfg: DeformableObjectCfg

    @property
    def data(self) -> DeformableObjectData:
        """The object's state."""
        return self._data

    @property
    def num_bodies(self) -> int:
        """Always 1."""
        return 1

    @property
    def max_sim_vertices_per_body(self) -> int:
        """Number of simulated nodes."""
        return len(self._nodes)

    @property
    def max_sim_elements_per_body(self) -> int:
        """Always 1: the cell that the nodes span."""
        return 1

    @property
    def max_collision_vertices_per_body(self) -> int:
        """Number of points at which contacts are found."""
        return int(self._physics.model.flex_vertnum[self._flex])

    @property
    def max_collision_elements_per_body(self) -> int:
        """Number of tetrahedra between those points."""
        return int(self._physics.model.flex_elemnum[self._flex])

    def spawn_into(self, spec: mujoco.MjSpec, name: str) -> None:
        """Spawn the asset and make its flex in a scene's spec (see :class:`AssetBase`).

        Raises:
            ConfigError: the spawner gives no soft body or several, the integrator cannot simulate one, or a property
                cannot be had.
        """
        self.name = name
        spawned = self._spawn(name)
        found = spawned.report.soft_bodies if spawned.report is not None else []
        if len(found) != 1:
            paths = ", ".join(body.prim_path for body in found) or "none (set spawn.deformable_props)"
            raise ConfigError(
                f"scene.{name}: a deformable object has exactly one deformable body, "
                f"'{self.cfg.prim_path}' has: {paths}"
            )
        self._check_integrator()
        adopt_scene_options(spawned, spec, f"scene.{name}")
        body = found[0]
        self._override(body)
        state = self.cfg.init_state
        quat = self._init_quat()
        position, total = np.zeros(3), np.zeros(4)
        mujoco.mju_rotVecQuat(position, np.asarray(body.position, dtype=np.float64), quat)
        mujoco.mju_mulQuat(total, quat, np.asarray(body.quat, dtype=np.float64))
        position += np.asarray(state.pos, dtype=np.float64)
        flex = add_flex(spec, body, f"{name}/{self.prim_name}", position, total)
        if self.cfg.spawn is not None and not self.cfg.spawn.visible:
            flex.group = 4

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find the nodes in the compiled model (see :class:`AssetBase`)."""
        super().initialize(physics, env_origins_w)
        model = physics.model
        self._flex = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_FLEX, f"{self.name}/{self.prim_name}")
        first, count = int(model.flex_nodeadr[self._flex]), int(model.flex_nodenum[self._flex])
        self._nodes = [int(b) for b in model.flex_nodebodyid[first : first + count]]
        joints = [int(model.body_jntadr[b]) + k for b in self._nodes for k in range(3)]
        self._qpos = as_columns([int(model.jnt_qposadr[j]) for j in joints], physics.device)
        self._qvel = as_columns([int(model.jnt_dofadr[j]) for j in joints], physics.device)
        self._data = DeformableObjectData(physics, env_origins_w, self._nodes, self._qpos, self._qvel)
        self._data.entity_name = self.name

    def update(self, dt: float) -> None:
        """Forget cached data: the engine's state has changed."""
        self._data.invalidate()

    def write_nodal_state_to_sim(self, nodal_state: Values, env_ids: EnvIds = None) -> None:
        """Set positions (m) and velocities (m/s) of the nodes.

        Args:
            nodal_state: world frame, shape (n, num nodes, 6), or what broadcasts to that from (num nodes, 6).
            env_ids: environments, or None for all.

        Raises:
            ConfigError: the shape does not fit.
        """
        ids = self._env_ids(env_ids)
        state = self._fit(nodal_state, ids, (len(self._nodes), 6), "write_nodal_state_to_sim")
        self._write_nodal_pos(state[..., :3], ids)
        self._write_nodal_velocity(state[..., 3:], ids)

    def write_nodal_pos_to_sim(self, nodal_pos: Values, env_ids: EnvIds = None) -> None:
        """Set positions of the nodes in m, world frame, shape (n, num nodes, 3) or (num nodes, 3).

        Raises:
            ConfigError: the shape does not fit.
        """
        ids = self._env_ids(env_ids)
        self._write_nodal_pos(self._fit(nodal_pos, ids, (len(self._nodes), 3), "write_nodal_pos_to_sim"), ids)

    def write_nodal_velocity_to_sim(self, nodal_vel: Values, env_ids: EnvIds = None) -> None:
        """Set velocities of the nodes in m/s, world frame.

        Args:
            nodal_vel: shape (n, num nodes, 3), or what broadcasts to that: one vector or number for all nodes.
            env_ids: environments, or None for all.

        Raises:
            ConfigError: the shape does not fit.
        """
        ids = self._env_ids(env_ids)
        shape = (len(self._nodes), 3)
        self._write_nodal_velocity(self._fit(nodal_vel, ids, shape, "write_nodal_velocity_to_sim", any_width=True), ids)

    def _write_nodal_pos(self, pos_w: torch.Tensor, ids: torch.Tensor | None) -> None:
        origins_w = self._env_origins_w if ids is None else self._env_origins_w[ids]
        offset = pos_w - origins_w[:, None] - self._data.home_pos
        self._physics.write("qpos", (offset @ self._data.home_rot).flatten(1), ids, self._qpos)
        self._data.invalidate()

    def _write_nodal_velocity(self, vel_w: torch.Tensor, ids: torch.Tensor | None) -> None:
        self._physics.write("qvel", (vel_w @ self._data.home_rot).flatten(1), ids, self._qvel)
        self._data.invalidate()

    def get_masses(self) -> torch.Tensor:
        """Current mass in kg, shape (num_envs, 1)."""
        return self._physics.randomizable("body_mass")[:, self._nodes].sum(dim=1, keepdim=True).float()

    def write_body_mass_to_sim(
        self,
        masses: torch.Tensor,
        body_ids: Sequence[int] | torch.Tensor | None = None,
        env_ids: EnvIds = None,
        recompute_inertia: bool = True,
    ) -> None:
        """Set the mass; the nodes share it as they do at start.

        Args:
            masses: in kg, shape (n, 1).
            body_ids: the one body, or None.
            env_ids: environments, or None for all.
            recompute_inertia: for the likeness with rigid bodies: nodes are points.

        Raises:
            ConfigError: a mass that is not positive.
        """
        self._check_masses(masses)
        rows = self._rows(env_ids)
        nodes = torch.tensor(self._nodes, device=rows.device)
        model = self._physics.model
        ratio = masses / self._data.default_mass[rows]
        for name in ("body_mass", "body_inertia"):
            field = self._physics.randomizable(name)
            default = torch.tensor(getattr(model, name)[self._nodes], dtype=field.dtype, device=field.device)
            field[rows[:, None], nodes] = default * ratio.to(field.dtype).view(-1, *[1] * default.ndim)
        self._physics.recompute_constants()

    def write_friction_to_sim(
        self, friction: torch.Tensor, body_ids: Sequence[int] | None = None, env_ids: EnvIds = None
    ) -> None:
        """Set the sliding friction.

        Args:
            friction: coefficient, shape (n,) or (n, 1).
            body_ids: the one body, or None.
            env_ids: environments, or None for all.
        """
        field = self._physics.randomizable("flex_friction")
        field[self._rows(env_ids), self._flex, 0] = friction.reshape(-1).to(field.dtype)

    def transform_nodal_pos(
        self, nodal_pos: torch.Tensor, pos: torch.Tensor | None = None, quat: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Turn nodes about their mean, then move them.

        Args:
            nodal_pos: positions in m, shape (n, num nodes, 3).
            pos: translation in m, shape (n, 3); None for none.
            quat: rotation (w, x, y, z), shape (n, 4); None for none.

        Returns:
            Positions in m, shape (n, num nodes, 3).
        """
        mean = nodal_pos.mean(dim=1, keepdim=True)
        return math_utils.transform_points(nodal_pos - mean, pos, quat) + mean

    def _check_integrator(self) -> None:
        sim = SimulationContext.instance()
        if sim is not None and sim.cfg.mujoco.integrator != INTEGRATOR:
            raise ConfigError(
                f"scene.{self.name} is deformable: set sim.mujoco.integrator='{INTEGRATOR}' "
                f"(it is '{sim.cfg.mujoco.integrator}')"
            )

    def _override(self, body: SoftBody) -> None:
        """What the spawner's config says beside the file."""
        spawn, path = self.cfg.spawn, f"scene.{self.name}.spawn"
        mass = getattr(spawn, "mass_props", None)
        if mass is not None and (mass.mass is not None or mass.density is not None):
            body.mass = mass.mass if mass.mass is not None else mass.density * float(np.prod(body.size))
            if not body.mass > 0:
                raise ConfigError(f"{path}.mass_props: mass and density must be positive, got {body.mass:g} kg")
        props = getattr(spawn, "deformable_props", None)
        if props is not None:
            if props.kinematic_enabled or props.deformable_enabled is False:
                raise ConfigError(f"{path}.deformable_props: a soft body can be neither kinematic nor switched off")
            default = DeformableBodyPropertiesCfg()
            for field, value in vars(props).items():
                if value != getattr(default, field):
                    note_ignored(f"{path}.deformable_props.{field}", "a soft body here is one cell of eight nodes")
        material = getattr(spawn, "visual_material", None)
        if isinstance(material, PreviewSurfaceCfg):
            red, green, blue = (linear_to_srgb(c) for c in material.diffuse_color)
            body.rgba = (red, green, blue, material.opacity)
