"""Base class of sensors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import mujoco
import torch

from lift_lab.utils.attributes import Entity
from lift_lab.utils.debug_vis import DebugVis
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.string import resolve_matching_names

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

    from .sensor_base_cfg import SensorBaseCfg

__all__ = ["SensorBase", "find_bodies_by_prim_path"]

_ENV_REGEX_NS = "/World/envs/env_.*"
"""What ``{ENV_REGEX_NS}`` stands for, where a config writes it out."""


class AssetPath(str):
    """Prim path of an asset, and where its bodies are below it."""

    stage_paths: Mapping[str, str] | None
    """Path of each body below the asset's prim, in the order of the stage; None where the engine's order holds."""

    def __new__(cls, path: str, stage_paths: Mapping[str, str] | None) -> AssetPath:
        """Hold both."""
        self = super().__new__(cls, path)
        self.stage_paths = stage_paths
        return self


class SensorBase(DebugVis, Entity, ABC):
    """A sensor reads the engine's state on demand."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_env_origins_w", "name"})

    def __init__(self, cfg: SensorBaseCfg):
        self.cfg = cfg.copy()

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

    @property
    def needs_every_substep(self) -> bool:
        """Whether the sensor must be updated after each physics step, so that substeps cannot be fused."""
        return False

    def build(self, spec: mujoco.MjSpec, name: str, prim_paths: Mapping[str, str]) -> None:
        """Add the sensor's elements to the scene's spec.

        Args:
            spec: the scene.
            name: the scene's name for the sensor.
            prim_paths: prim path of every asset and terrain, by the scene's name for it; those of assets are
                :class:`AssetPath`.
        """
        self.name = name

    def initialize(self, physics: Physics, env_origins_w: torch.Tensor) -> None:
        """Find the sensor's parts in the compiled model."""
        self._physics = physics
        self._env_origins_w = env_origins_w

    def reset(self, env_ids: Sequence[int] | torch.Tensor | slice | None = None) -> None:
        """Forget past readings of some environments."""

    def update(self, dt: float, force_recompute: bool = False) -> None:
        """Take note that the engine moved on by ``dt`` seconds."""


def find_asset_by_prim_path(prim_paths: Mapping[str, str], prim_path: str, where: str) -> tuple[str, str | None]:
    """The asset whose prim path a path begins with, and what follows in it.

    Args:
        prim_paths: prim path of every asset, by name.
        prim_path: e.g. ``"{ENV_REGEX_NS}/Robot/panda_hand"``.
        where: for messages, e.g. ``"scene.ee_frame.prim_path"``.

    Returns:
        The asset's name and the last part of the path, None where the path is the asset's own.

    Raises:
        ConfigError: no asset answers to the path.
    """
    wanted = prim_path.replace(_ENV_REGEX_NS, "{ENV_REGEX_NS}")
    for name, path in prim_paths.items():
        base = path.replace(_ENV_REGEX_NS, "{ENV_REGEX_NS}")
        if wanted == base:
            return name, None
        if wanted.startswith(f"{base}/"):
            return name, wanted.rsplit("/", 1)[-1]
    known = prim_paths.values()
    raise ConfigError(f"{where}: no asset has the prim path '{prim_path}'; {suggest(prim_path, known)}")


def find_bodies_by_prim_path(
    spec: mujoco.MjSpec, prim_paths: Mapping[str, str], prim_path: str, where: str
) -> list[str]:
    """Names in the scene's spec of the bodies that a prim path pattern means.

    A path is an asset's own prim path (its root body), or that followed by body names, of which the last counts.
    Several bodies come in the order of the stage, as PhysX's views have them.

    Args:
        spec: the scene.
        prim_paths: prim path of every asset, by name.
        prim_path: e.g. ``"{ENV_REGEX_NS}/Robot/panda_hand"``; the last part may be a regular expression.
        where: for messages, e.g. ``"scene.ee_frame.prim_path"``.

    Raises:
        ConfigError: no asset or body answers to the path.
    """
    name, leaf = find_asset_by_prim_path(prim_paths, prim_path, where)
    bodies = [b.name[len(name) + 1 :] for b in spec.bodies if b.name.startswith(f"{name}/")]
    if not bodies:
        raise ConfigError(f"{where}: '{name}' is static, it has no body")
    if leaf is None:
        return [f"{name}/{bodies[0]}"]
    place = {body: i for i, body in enumerate(_stage_paths(prim_paths, name) or ())}
    bodies.sort(key=lambda body: place.get(body, len(place)))
    try:
        _, found = resolve_matching_names([leaf], bodies)
    except ValueError:
        raise ConfigError(f"{where}: '{name}' has no body '{leaf}'; {suggest(leaf, bodies)}") from None
    return [f"{name}/{body}" for body in found]


def body_prim_path(prim_paths: Mapping[str, str], body: str) -> str:
    """Prim path of a body of the scene's spec, e.g. ``"{ENV_REGEX_NS}/Robot/panda_hand"``.

    Args:
        prim_paths: prim path of every asset, by name.
        body: its name there, ``"robot/panda_hand"``.
    """
    name, _, leaf = body.partition("/")
    below = _stage_paths(prim_paths, name) or {}
    return prim_paths[name].replace(_ENV_REGEX_NS, "{ENV_REGEX_NS}") + below.get(leaf, f"/{leaf}")


def has_engine_order(prim_paths: Mapping[str, str], body: str) -> bool:
    """Whether the asset of a body of the scene's spec asks for the engine's order."""
    return _stage_paths(prim_paths, body.partition("/")[0]) is None


def _stage_paths(prim_paths: Mapping[str, str], name: str) -> Mapping[str, str] | None:
    path = prim_paths[name]
    return path.stage_paths if isinstance(path, AssetPath) else {}
