"""Physics engines behind one interface: MuJoCo on a thread pool ("native") and MuJoCo-Warp ("warp").

The engine's own package is imported when one is made, so that a CPU run never pays for warp.
"""

from __future__ import annotations

from typing import Literal

import mujoco
import torch

from lift_lab.utils.errors import ConfigError, suggest

from .base import DERIVED_FIELDS, STATE_FIELDS, Health, Physics, Stage
from .memory import check_fits, native_bytes
from .model_fields import CONSTANT_INPUTS, RANDOMIZABLE_FIELDS

PHYSICS_KINDS = ("native", "warp")
"""The engines there are."""


def make_physics(
    model: mujoco.MjModel,
    num_envs: int,
    device: str | torch.device = "cpu",
    kind: Literal["native", "warp"] | None = None,
    num_threads: int | None = None,
    nconmax: int | None = None,
    njmax: int | None = None,
) -> Physics:
    """Make `num_envs` simulations of a model.

    Args:
        model: the compiled model; it is copied.
        num_envs: number of environments.
        device: where the tensors live, "cpu" or "cuda:N".
        kind: "native" (CPU, float64 inside) or "warp" (CUDA, also CPU; float32); None takes warp on CUDA and
            native elsewhere.
        num_threads: threads of the native engine, None for every CPU this process may use; results do not
            depend on it, and warp has none.
        nconmax: contacts per environment that warp allocates, None for an estimate; native needs no bound.
        njmax: constraint rows per environment that warp allocates, as `nconmax`.

    Raises:
        ConfigError: unknown kind, or one that cannot run on the device, or more environments than fit into memory.
    """
    device = torch.device(device)
    if kind is None:
        kind = "warp" if device.type == "cuda" else "native"
    if kind == "native":
        from .native import NativePhysics

        check_fits("scene.num_envs", num_envs, native_bytes(model), device)
        return NativePhysics(model, num_envs, device, num_threads=num_threads)
    if kind == "warp" and model.nflex:
        raise ConfigError("soft bodies are simulated by the native engine only; choose sim.device='cpu'")
    if kind == "warp":
        from .warp import WarpPhysics

        return WarpPhysics(model, num_envs, device, nconmax=nconmax, njmax=njmax)
    raise ConfigError(f"unknown physics '{kind}'; {suggest(kind, PHYSICS_KINDS)}")
