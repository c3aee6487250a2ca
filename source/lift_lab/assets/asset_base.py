"""Base class of assets: spawning into the scene's MjSpec, and lookup in the compiled model."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar

import mujoco
import numpy as np
import torch

from lift_lab.sim.physics.base import ids_tensor
from lift_lab.sim.schemas import apply_schemas
from lift_lab.sim.spawners.file_options import adopt_scene_options
from lift_lab.sim.spawners.spawner_cfg import Spawned
from lift_lab.usd.filters import separate_classes
from lift_lab.utils.attributes import Entity
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.indexing import EnvIds

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

    from .asset_base_cfg import AssetBaseCfg

__all__ = [
    "AssetBase",
]

logger = logging.getLogger(__name__)

Values = torch.Tensor | np.ndarray | Sequence[float] | float
"""Argument of methods that write states: anything that makes a tensor and broadcasts to the shape they name."""


class AssetBase(Entity):
    """A spawned thing. This class itself serves static ones, which have a place and no state."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_env_origins_w", "name", "spawned"})

    def __init__(self, cfg: AssetBaseCfg):
        """Hold the config; the scene spawns the asset with :meth:`spawn_into`."""
        self.cfg = cfg.copy()
        self.spawned: Spawned | None = None

    @property
    def prim_name(self) -> str:
        """Last part of the prim path."""
        return self.cfg.prim_path.rsplit("/", 1)[-1]

    @property
    def stage_paths(self) -> dict[str, str] | None:
        """Path of each body below the asset's prim, in the order of the stage, where there are several.

        None where sensors keep the engine's order.
        """
        return {}

    @property
    def physics(self) -> Physics:
        """The engine that simulates the asset."""
        return self._physics

    @property
    def device(self) -> str:
        """Torch device of the asset's tensors."""
        return str(self._physics.device)

    @property
    def num_instances(self) -> int:
        """Number of environments."""
        return self._physics.num_envs

    @property
    def is_initialized(self) -> bool:
        """Whether the asset was found in the running engine."""
        return hasattr(self, "_physics")

    def spawn_into(self, spec: mujoco.MjSpec, name: str) -> None:
        """Spawn the asset and attach it to a scene's spec; its names get the prefix ``name/``.

        Args:
            spec: the scene.
            name: the scene's name for the asset.

        Raises:
            ConfigError: there is no spawner, or contact rules need more bits than MuJoCo has.
        """
        self.name = name
        spawned = self._spawn(name)
        if spawned.report is not None and spawned.report.soft_bodies:
            raise ConfigError(f"scene.{name}: '{self.cfg.prim_path}' is deformable; use DeformableObjectCfg for it")
        child = spawned.spec
        apply_schemas(child, self.cfg.spawn, f"scene.{name}.spawn")
        self._edit_spec(child)
        if spawned.report is not None:
            separate_classes(child, spawned.report.contact_classes, spec)
        adopt_scene_options(spawned, spec, f"scene.{name}")
        frame = spec.worldbody.add_frame(pos=list(self.cfg.init_state.pos), quat=self._init_quat())
        spec.attach(child, prefix=f"{name}/", frame=frame)

    def _spawn(self, name: str) -> Spawned:
        if self.cfg.spawn is None:
            raise ConfigError(f"scene.{name}.spawn is None: there is no stage from which '{self.cfg.prim_path}' comes")
        spawned: Spawned = self.cfg.spawn.func(self.cfg.prim_path, self.cfg.spawn)
        self.spawned = spawned
        return spawned

    def _init_quat(self) -> np.ndarray:
        """Orientation in the environment's frame (w, x, y, z), of unit length."""
        rot = np.asarray(self.cfg.init_state.rot, dtype=np.float64)
        norm = float(np.linalg.norm(rot))
        if not np.isfinite(norm) or norm < 1e-6:
            raise ConfigError(f"scene.{self.name}.init_state.rot {tuple(rot)} is not an orientation")
        return rot / norm

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find the asset in the compiled model.

        Args:
            physics: the running engine.
            env_origins_w: origin of each environment in the world, shape (num_envs, 3).
        """
        self._physics = physics
        self._env_origins_w = env_origins_w

    def reset(self, env_ids: EnvIds = None) -> None:
        """Reset the asset's own buffers of some environments."""

    def write_data_to_sim(self) -> None:
        """Send what was set to the engine."""

    def update(self, dt: float) -> None:
        """Take note that the engine moved on by ``dt`` seconds."""

    def _edit_spec(self, spec: mujoco.MjSpec) -> None:
        """Change the asset's own spec before it joins the scene."""

    def _body_ids(self) -> list[int]:
        model = self._physics.model
        return [i for i in range(model.nbody) if model.body(i).name.startswith(f"{self.name}/")]

    def _local_name(self, name: str) -> str:
        return name[len(self.name) + 1 :]

    def _check_masses(self, masses: torch.Tensor) -> None:
        wrong = ~((masses > 0) & masses.isfinite())
        if bool(wrong.any()):
            raise ConfigError(f"'{self.name}': masses must be positive, got {float(masses[wrong][0])}")

    def _check_range(self, values: torch.Tensor, name: str, least: float, finite: bool = True) -> None:
        """Raise ConfigError if a number is below ``least`` or, if ``finite``, infinite; not on a GPU: it would wait."""
        if not values.is_cpu:
            return
        wrong = ~(values >= least)
        if finite:
            wrong |= ~values.isfinite()
        if bool(wrong.any()):
            bounds = "finite" if least == -torch.inf else f"{'finite and ' if finite else ''}at least {least:g}"
            raise ConfigError(f"'{self.name}'.{name}: must be {bounds}, got {float(values[wrong][0]):g}")

    def _rows(self, env_ids: EnvIds) -> torch.Tensor:
        """Environment ids as a LongTensor on the device, also of all."""
        ids = self._env_ids(env_ids)
        return torch.arange(self.num_instances, device=self._physics.device) if ids is None else ids

    def _env_ids(self, env_ids: EnvIds) -> torch.Tensor | None:
        """Environment ids as a LongTensor on the device; None for all.

        Raises:
            ConfigError: a mask, fractions, several dimensions, or an environment that there is not.
        """
        if env_ids is None or (isinstance(env_ids, slice) and env_ids == slice(None)):
            return None
        if isinstance(env_ids, slice):
            return torch.arange(self.num_instances, device=self.device)[env_ids]
        try:
            return ids_tensor(env_ids, self._physics.device, self.num_instances).reshape(-1)
        except ConfigError as error:
            raise ConfigError(f"'{self.name}': env_ids: {error}") from error

    def _fit(
        self, values: Values, env_ids: torch.Tensor | None, shape: tuple[int, ...], method: str, any_width: bool = False
    ) -> torch.Tensor:
        """Values on the device, broadcast to one entry of ``shape`` for each environment.

        Args:
            values: a tensor, or what makes one.
            env_ids: the environments as :meth:`_env_ids` gives them.
            shape: of one environment's entry.
            method: who asks, for the message.
            any_width: whether a single number may stand for all columns.

        Raises:
            ConfigError: no numbers, or their shape does not fit.
        """
        wanted = (self._count(env_ids), *shape)
        values = self._numbers(values, method, wanted)
        if values.shape == wanted:
            return values
        if any_width or (values.ndim and values.shape[-1] == shape[-1]):
            try:
                return values.expand(wanted)
            except RuntimeError:
                pass
        raise ConfigError(f"'{self.name}'.{method}: values of shape {tuple(values.shape)} do not fit {wanted}")

    def _numbers(self, values: Values, method: str, wanted: tuple[int, ...]) -> torch.Tensor:
        """Values as :func:`as_numbers` has them."""
        return as_numbers(values, self._physics.device, wanted, f"'{self.name}'.{method}")

    def _count(self, env_ids: torch.Tensor | None) -> int:
        return self.num_instances if env_ids is None else len(env_ids)


def as_numbers(values: Values, device: torch.device, wanted: tuple[int, ...], what: str) -> torch.Tensor:
    """Convert values of any type to a float32 tensor on a device.

    Args:
        values: a tensor, or what makes one.
        device: of the result.
        wanted: the shape that they should fit, for the message.
        what: how the message calls them.

    Raises:
        ConfigError: no real numbers.
    """
    if not isinstance(values, torch.Tensor):
        try:
            values = torch.as_tensor(values)
        except (TypeError, ValueError, RuntimeError) as error:
            raise ConfigError(f"{what}: expected numbers that fit shape {wanted}, got {values!r}") from error
    if values.dtype == torch.float32 and values.device == device:
        return values
    if values.dtype == torch.bool or values.is_complex():
        raise ConfigError(f"{what}: expected real numbers, got {values.dtype}")
    return values.to(device=device, dtype=torch.float32)


def as_list(ids: Sequence[int] | torch.Tensor | slice | None, count: int) -> list[int]:
    """Numbers of bodies or joints; None means all ``count``. Raises ConfigError for other values."""
    if ids is None or isinstance(ids, slice):
        return list(range(count))[ids or slice(None)]
    return ids_tensor(ids, torch.device("cpu"), count).reshape(-1).tolist()


def as_columns(ids: Sequence[int], device: torch.device) -> slice | torch.Tensor:
    """Column indices as a slice where they are contiguous, so that reading them makes a view; else as a tensor."""
    ids = list(ids)
    if ids and ids == list(range(ids[0], ids[0] + len(ids))):
        return slice(ids[0], ids[0] + len(ids))
    return torch.tensor(ids, dtype=torch.long, device=device)


def take_columns(values: torch.Tensor, cols: slice | torch.Tensor) -> torch.Tensor:
    """``values[:, cols]`` for an index of :func:`as_columns`: a view of a slice, else one copy."""
    return values[:, cols] if isinstance(cols, slice) else values.index_select(1, cols)
