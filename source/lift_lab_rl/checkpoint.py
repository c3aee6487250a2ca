"""The state of a running environment, so that a run can go on as if it had never stopped.

A manager-based environment is a graph of objects (managers, terms, assets, sensors). :func:`env_state` writes down the
attributes of all of them, whatever a task brings along; :func:`load_env_state` writes them into another environment of
the same configuration, or into the same one later. The engine's own state, in its own precision, is in the entry
``physics``. What a class says about its part of the state is in :mod:`lift_lab.utils.saved_state`.

What cannot be written down (an iterator, an open file, an object of another library that does not save itself) is
named in the entry ``unsaved``, so that nothing is lost without a word.
"""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import torch

from lift_lab.markers import VisualizationMarkers
from lift_lab.sim import SimulationContext
from lift_lab.sim.physics.base import Physics
from lift_lab.utils.errors import StateMismatchError

from .state_capture import Capture
from .state_restore import Restore

VERSION = 3
"""Version of the form of a saved state."""


def _is_left_out(value: Any) -> bool:
    """Whether an object is restored otherwise (the engine) or not at all (markers: a run may be filmed or not)."""
    return isinstance(value, (Physics, SimulationContext, VisualizationMarkers))


def env_state(env: Any) -> dict[str, Any]:
    """Everything that the future of an environment depends on.

    Args:
        env: a manager-based environment (unwrapped).

    Returns:
        ``version``: of the form. ``physics``: the engine's state. ``objects``: all attributes as a tree of tensors
        (copies, on the CPU) and plain values, see :mod:`.state_nodes`. ``unsaved``: path and type of what could not be
        written down. The global random numbers are not in it: see :func:`rng_state`.
    """
    capture = Capture(env.sim.physics.storages(), _is_left_out, env.device)
    objects = capture.node(env, "")
    return {
        "version": VERSION,
        "num_envs": env.num_envs,
        "physics": env.sim.physics.state_dict(),
        "objects": objects,
        "unsaved": capture.unsaved,
    }


def load_env_state(env: Any, state: dict[str, Any]) -> None:
    """Write a state of :func:`env_state` back.

    Args:
        env: an environment of the same configuration.
        state: the state.

    Raises:
        StateMismatchError: the environment holds other things than the state; names the first of them. The
            environment is unchanged then.
    """
    version = state.get("version", 1) if isinstance(state, dict) else None
    if type(version) is not int:
        raise StateMismatchError("the saved state is not valid: it has no version")
    if version != VERSION:
        raise StateMismatchError(f"the saved state has the form of version {version}, this is version {VERSION}")
    num_envs = state.get("num_envs")
    if type(num_envs) is not int:
        raise StateMismatchError("the saved state is not valid: it has no number of environments")
    if num_envs != env.num_envs:
        raise StateMismatchError(f"the saved state has {num_envs} environments, this run {env.num_envs}")
    physics = env.sim.physics
    physics.check_state_dict(state.get("physics"))
    restore = Restore(physics.storages(), _is_left_out, env.device)
    restore.plan(env, state.get("objects"))
    physics.load_state_dict(state["physics"])
    restore.apply()


# -- random numbers


def rng_state() -> dict[str, Any]:
    """State of torch's, numpy's and Python's global random numbers."""
    name, keys, position, has_gauss, gauss = np.random.get_state()  # noqa: NPY002 - the global generator is meant
    version, numbers, gauss_next = random.getstate()
    state: dict[str, Any] = {
        "torch": torch.get_rng_state(),
        "numpy": [str(name), torch.from_numpy(np.asarray(keys, np.int64)), int(position), int(has_gauss), float(gauss)],
        "python": [version, torch.tensor(numbers, dtype=torch.int64), gauss_next],
    }
    if torch.cuda.is_available():
        state["cuda"] = torch.cuda.get_rng_state_all()
    return state


def check_rng_state(state: dict[str, Any]) -> None:
    """Check that a state can be written back; touches no generator in use.

    Raises:
        Exception: of torch, numpy or Python; the state is none of :func:`rng_state`.
    """
    torch.Generator().set_state(state["torch"])
    name, keys, position, has_gauss, gauss = state["numpy"]
    np.random.RandomState().set_state((name, keys.numpy().astype(np.uint32), position, has_gauss, gauss))
    version, numbers, gauss_next = state["python"]
    random.Random().setstate((version, tuple(numbers.tolist()), gauss_next))
    for values in state.get("cuda", ()):
        if not isinstance(values, torch.Tensor) or values.dtype != torch.uint8:
            raise TypeError("the state of a GPU's random numbers has to be a tensor of bytes")


def load_rng_state(state: dict[str, Any]) -> None:
    """Write a state of :func:`rng_state` back."""
    torch.set_rng_state(state["torch"])
    name, keys, position, has_gauss, gauss = state["numpy"]
    np.random.set_state((name, keys.numpy().astype(np.uint32), position, has_gauss, gauss))  # noqa: NPY002
    version, numbers, gauss_next = state["python"]
    random.setstate((version, tuple(numbers.tolist()), gauss_next))
    if "cuda" in state and torch.cuda.is_available() and len(state["cuda"]) == torch.cuda.device_count():
        torch.cuda.set_rng_state_all(state["cuda"])
