"""What all sensors share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import mujoco
import torch

from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.string import resolve_matching_names

if TYPE_CHECKING:
    from lift_lab.assets import Articulation, RigidObject
    from lift_lab.sim.physics.base import Physics

    from .sensor_base_cfg import SensorBaseCfg


class SensorBase(ABC):
    """A sensor reads the engine's state on demand."""

    def __init__(self, cfg: SensorBaseCfg):
        self.cfg = cfg.copy()
        self.name = ""

    @property
    @abstractmethod
    def data(self) -> Any:
        """The sensor's readings."""

    @property
    def num_instances(self) -> int:
        """Number of environments."""
        return self._physics.num_envs

    @property
    def device(self) -> str:
        """Torch device of the readings."""
        return str(self._physics.device)

    def build(self, spec: mujoco.MjSpec, name: str, assets: Mapping[str, Articulation | RigidObject]) -> None:
        """Add to the scene's spec what the sensor needs there."""
        self.name = name

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find the sensor's parts in the compiled model."""
        self._physics = physics
        self._env_origins_w = env_origins_w

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None = None) -> None:
        """Forget past readings of some environments."""

    def update(self, dt: float, force_recompute: bool = False) -> None:
        """Take note that the engine moved on by ``dt`` seconds."""


def find_bodies_by_prim_path(
    spec: mujoco.MjSpec, assets: Mapping[str, Articulation | RigidObject], prim_path: str, where: str
) -> list[str]:
    """Names in the scene's spec of the bodies that a prim path pattern means.

    A path is an asset's own prim path (its root body), or that followed by body names, of which the last counts.

    Args:
        spec: the scene.
        assets: assets by name.
        prim_path: e.g. ``"{ENV_REGEX_NS}/Robot/panda_hand"``; the last part may be a regular expression.
        where: for messages, e.g. ``"scene.ee_frame.prim_path"``.

    Raises:
        ConfigError: no asset or body answers to the path.
    """
    for name, asset in assets.items():
        base = asset.cfg.prim_path
        if prim_path != base and not prim_path.startswith(f"{base}/"):
            continue
        bodies = [b.name[len(name) + 1 :] for b in spec.bodies if b.name.startswith(f"{name}/")]
        if prim_path == base:
            return [f"{name}/{bodies[0]}"]
        leaf = prim_path.rsplit("/", 1)[-1]
        try:
            _, found = resolve_matching_names([leaf], bodies)
        except ValueError:
            raise ConfigError(f"{where}: '{name}' has no body '{leaf}'; {suggest(leaf, bodies)}") from None
        return [f"{name}/{body}" for body in found]
    known = [asset.cfg.prim_path for asset in assets.values()]
    raise ConfigError(f"{where}: no asset has the prim path '{prim_path}'; {suggest(prim_path, known)}")
