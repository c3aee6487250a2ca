"""The physics engines by name, and which one a device gets.

An engine is a class below :class:`~lift_lab.sim.physics.base.Physics`. Code above the engine does not use its name.
Decisions that depend on the engine are made by its class. A package adds an engine by an entry point of the group
:data:`GROUP`, ``name = "module:Class"``. Importing this module imports no engine.
"""

from __future__ import annotations

import importlib
import importlib.metadata
from typing import TYPE_CHECKING

from lift_lab.utils.errors import ConfigError, suggest

if TYPE_CHECKING:
    import torch

    from .physics.base import Physics

ENGINES: dict[str, str] = {
    "native": "lift_lab.sim.physics.native:NativePhysics",
    "warp": "lift_lab.sim.physics.warp:WarpPhysics",
}
"""Module and class of each engine of this project. A program may add its own."""

DEFAULTS: dict[str, str] = {"cpu": "native", "cuda": "warp"}
"""The engine of each type of device where none is named."""

GROUP = "lift_lab.physics"
"""Group of the entry points by which packages add engines."""


def engine_names() -> list[str]:
    """Names of all engines, those of other packages included; loads none of them."""
    return list(dict.fromkeys([*ENGINES, *sorted(point.name for point in _entry_points())]))


def engine_class(name: str | None, device: str | torch.device) -> type[Physics]:
    """Load the class of an engine.

    Args:
        name: the engine; None for the default of the device.
        device: torch device, such as ``"cpu"`` or ``"cuda:0"``.

    Raises:
        ConfigError: there is no engine of that name, several packages have one, or it cannot be loaded.
    """
    if name is None:
        kind = str(device).partition(":")[0]
        if kind not in DEFAULTS:
            raise ConfigError(f"no physics engine is the default on device '{device}'; name one in sim.physics")
        name = DEFAULTS[kind]
    found = [ENGINES[name]] if name in ENGINES else []
    found += [point.value for point in _entry_points() if point.name == name and point.value not in found]
    if not found:
        raise ConfigError(f"unknown physics '{name}'; {suggest(name, engine_names())}")
    if len(found) > 1:
        raise ConfigError(f"several packages have a physics engine '{name}': {', '.join(found)}")
    return _load(name, found[0])


def _entry_points() -> list[importlib.metadata.EntryPoint]:
    return list(importlib.metadata.entry_points(group=GROUP))


def _load(name: str, place: str) -> type[Physics]:
    from .physics.base import Physics

    module, _, attribute = place.partition(":")
    try:
        engine = getattr(importlib.import_module(module.strip()), attribute.strip())
    except Exception as error:  # of a package of somebody else, anything can be wrong
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise ConfigError(f"the physics engine '{name}' cannot be loaded from '{place}': {reason}") from error
    if not (isinstance(engine, type) and issubclass(engine, Physics)):
        raise ConfigError(f"the physics engine '{name}' cannot be loaded: '{place}' is no sub-class of Physics")
    return engine
