"""Physics engines behind one interface; :mod:`lift_lab.sim.engines` lists them.

An engine's own package is imported when one is made, so that a CPU run never pays for warp.
"""

from __future__ import annotations

import inspect
from typing import Any

import mujoco
import torch

from lift_lab.sim.engines import engine_class
from lift_lab.utils.errors import ConfigError, suggest

from .base import DERIVED_FIELDS, STATE_FIELDS, Health, Physics, Stage
from .model_fields import CONSTANT_INPUTS, RANDOMIZABLE_FIELDS

__all__ = [
    "CONSTANT_INPUTS",
    "DERIVED_FIELDS",
    "RANDOMIZABLE_FIELDS",
    "STATE_FIELDS",
    "Health",
    "Physics",
    "Stage",
    "make_physics",
]


def make_physics(
    model: mujoco.MjModel,
    num_envs: int,
    device: str | torch.device = "cpu",
    kind: str | None = None,
    auto_reset_failed: bool = False,
    **options: Any,
) -> Physics:
    """Make `num_envs` simulations of a model.

    Args:
        model: the compiled model; it is copied.
        num_envs: number of environments.
        device: device of the tensors, "cpu" or "cuda:N".
        kind: name of the engine: "native" (CPU, float64 inside) or "warp" (CUDA, also CPU; float32). None is the
            device's default: warp on CUDA, native on the CPU.
        auto_reset_failed: see :attr:`Physics.auto_reset_failed`.
        **options: options of the engine. native: `num_threads`, None for every CPU this process may use; results do not
            depend on it. warp: `nconmax` and `njmax`, contacts and constraint rows to allocate per environment. None is
            an estimate.

    Raises:
        ConfigError: an unknown engine or option, an engine that cannot run on the device, or more environments than
            fit into memory.
    """
    engine = engine_class(kind, device)
    known = list(inspect.signature(engine).parameters)
    for name in options:
        if name not in known:
            raise ConfigError(f"the physics engine '{engine.name}' has no option '{name}'; {suggest(name, known[3:])}")
    return engine(model, num_envs, torch.device(device), auto_reset_failed=auto_reset_failed, **options)
