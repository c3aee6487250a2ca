"""The state of a running environment, so that a run can go on as if it had never stopped.

A manager-based environment is a graph of objects (managers, terms, assets, sensors) that hold tensors and counters.
:func:`env_state` walks that graph and returns every tensor and number by its path; :func:`load_env_state` writes them
back into another environment of the same configuration. Terms that a task brings along are covered without
knowing of it. The engine's own state, in its own precision, is in the entry ``physics``.

What is passed over: configuration of the environment, the physics engine's tensors (restored by the engine), text,
functions, sets of anything but numbers, and objects of other libraries. A term that hides state in one of those cannot
be continued exactly.
"""

from __future__ import annotations

import enum
import random
import sys
from collections import deque
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import torch

from lift_lab.markers import VisualizationMarkers
from lift_lab.utils.errors import LiftLabError

from .physics_state import load_physics_state, physics_state, physics_storages

_Assign = Callable[[Any], None]


class StateMismatchError(LiftLabError, ValueError):
    """A saved state is of an environment of another shape."""


_FOREIGN = frozenset(
    sys.stdlib_module_names
    | {"torch", "numpy", "mujoco", "mujoco_warp", "warp", "gymnasium", "rich", "pxr", "tensordict", "viser"}
)
"""Top-level modules whose objects are not looked into."""

_SKIPPED_ATTRIBUTES = frozenset(
    {"_env", "env", "_physics", "physics", "sim", "_sim", "spec", "spawned", "_debug_vis", "log_counts"}
    | {"wants_final_obs"}
)
"""Attributes that lead back to the environment, to the engine, or to what the model was built from, that say whether
markers are shown (a run may be filmed or not), that belong to the last reset's log, or that a wrapper sets."""

_CACHES = frozenset({"_cache", "_kept"})
"""Attributes that hold what can be computed again: not saved, and emptied when a state is loaded."""


def env_state(env: Any) -> dict[str, Any]:
    """Everything that the future of an environment depends on.

    Args:
        env: a manager-based environment (unwrapped).

    Returns:
        ``physics``: the engine's state. ``objects``: path -> tensor (a copy, on the CPU), number, or list of numbers.
        ``aliases``: path -> first path that leads to the same tensor. The global random numbers are not in it: see
        :func:`rng_state`.
    """
    leaves = list(_leaves(env, physics_storages(env.sim.physics)))
    aliases = _aliases(leaves)
    objects = {path: _saved(leaf) for path, leaf, _ in leaves if path not in aliases}
    return {"physics": physics_state(env.sim.physics), "objects": objects, "aliases": aliases}


def load_env_state(env: Any, state: dict[str, Any]) -> None:
    """Write a state of :func:`env_state` back.

    Args:
        env: an environment of the same configuration.
        state: the state.

    Raises:
        StateMismatchError: the environment holds other things than the state; names the first of them. The
            environment should then be reset.
    """
    rows = next(iter(state["physics"]["rows"].values()))
    if len(rows) != env.num_envs:
        raise StateMismatchError(f"the saved state has {len(rows)} environments, this run {env.num_envs}")
    load_physics_state(env.sim.physics, state["physics"])
    live = list(_leaves(env, physics_storages(env.sim.physics)))
    saved, saved_aliases, live_aliases = state["objects"], state["aliases"], _aliases(live)
    different = sorted({path for path, _, _ in live} ^ (saved.keys() | saved_aliases.keys()))
    if different:
        raise StateMismatchError(
            f"the saved state is of another environment: {len(different)} entries differ, first '{different[0]}'"
        )
    groups: dict[str, set[str]] = {}
    for path, _, _ in live:
        groups.setdefault(live_aliases.get(path, path), set()).add(saved_aliases.get(path, path))
    made: dict[str, Any] = {}
    for path, leaf, assign in live:
        source = saved_aliases.get(path, path)
        if len(groups[live_aliases.get(path, path)]) == 1:
            if path not in live_aliases:
                _restore(path, leaf, assign, saved[source])
        else:
            # One tensor here (as at construction) that became several there: each path gets its own again.
            if source not in made:
                made[source] = saved[source].to(leaf.device).clone()
            assign(made[source])
    for cache in _caches(env):
        cache.clear()


def _aliases(leaves: list[tuple[str, Any, _Assign]]) -> dict[str, str]:
    """Path -> first path to the same tensor, for all but the first."""
    first: dict[int, str] = {}
    found = {}
    for path, leaf, _ in leaves:
        if isinstance(leaf, torch.Tensor):
            if id(leaf) in first:
                found[path] = first[id(leaf)]
            else:
                first[id(leaf)] = path
    return found


# -- the walk


def _leaves(env: Any, excluded: set[int]) -> Iterator[tuple[str, Any, _Assign]]:
    """(path, leaf, how to replace it) for every tensor, array, generator and number below the environment."""
    seen: set[int] = {id(env)}
    # The managers' copies of the configuration are state (curricula edit them), the environment's own is not.
    for name, value in list(vars(env).items()):
        if name not in ("cfg", "extras") and name not in _SKIPPED_ATTRIBUTES | _CACHES:
            yield from _below(name, value, _attribute_setter(env, name), seen, excluded)


def _below(path: str, value: Any, assign: _Assign, seen: set[int], excluded: set[int]) -> Iterator[Any]:
    if _is_number(value) or isinstance(value, np.generic):
        yield path, value, assign
        return
    if isinstance(value, torch.Tensor):
        if value.untyped_storage().data_ptr() not in excluded or not value.numel():
            yield path, value, assign
    elif id(value) in seen:
        return
    elif isinstance(value, (np.ndarray, np.random.Generator, torch.Generator)):
        seen.add(id(value))
        yield path, value, assign
    elif isinstance(value, dict):
        seen.add(id(value))
        for key in list(value):
            yield from _below(f"{path}[{key!r}]", value[key], _item_setter(value, key), seen, excluded)
    elif isinstance(value, (list, deque, set)):
        seen.add(id(value))
        if isinstance(value, set) and not all(_is_number(item) for item in value):
            return
        if all(_is_number(item) for item in value):
            yield path, value, assign
        else:
            for k, item in enumerate(value):
                yield from _below(f"{path}[{k}]", item, _item_setter(value, k), seen, excluded)
    elif isinstance(value, tuple):
        items = list(value)
        for k, item in enumerate(value):
            yield from _below(f"{path}[{k}]", item, _tuple_setter(value, items, k, assign), seen, excluded)
    elif _is_ours(value):
        seen.add(id(value))
        for name, item in list(vars(value).items()):
            if name not in _SKIPPED_ATTRIBUTES | _CACHES:
                yield from _below(f"{path}.{name}", item, _attribute_setter(value, name), seen, excluded)


def _is_ours(value: Any) -> bool:
    """Whether to look into an object: an instance of a class of this project or of the task's author."""
    if isinstance(value, (type, enum.Enum, VisualizationMarkers)) or not hasattr(value, "__dict__"):
        return False
    return type(value).__module__.partition(".")[0] not in _FOREIGN


def _caches(env: Any) -> Iterator[dict]:
    """Caches of the assets and sensors."""
    for entity in (env.scene[name] for name in env.scene.keys()):  # noqa: SIM118 - a scene is no dictionary
        for holder in (entity, getattr(entity, "data", None)):
            for name in _CACHES:
                if isinstance(getattr(holder, name, None), dict):
                    yield getattr(holder, name)


def _is_number(value: Any) -> bool:
    return type(value) in (type(None), bool, int, float)


def _attribute_setter(owner: Any, name: str) -> _Assign:
    return lambda value: object.__setattr__(owner, name, value)


def _item_setter(owner: Any, key: Any) -> _Assign:
    return lambda value: owner.__setitem__(key, value)


def _tuple_setter(owner: tuple, items: list, k: int, assign: _Assign) -> _Assign:
    """A tuple cannot be written into: one with the new entry takes its place, unless the entry is the same.

    Args:
        owner: the tuple.
        items: its entries, with those that were replaced so far.
        k: number of the entry.
        assign: how to replace the tuple.
    """

    def replace(value: Any) -> None:
        if isinstance(value, torch.Tensor) or type(value) is not type(items[k]) or value != items[k]:
            items[k] = value
            assign(type(owner)(*items) if hasattr(owner, "_fields") else type(owner)(items))

    return replace


# -- one leaf


def _saved(leaf: Any) -> Any:
    if isinstance(leaf, torch.Tensor):
        return leaf.detach().cpu().clone()
    if isinstance(leaf, np.ndarray):
        return torch.from_numpy(np.array(leaf))
    if isinstance(leaf, np.random.Generator):
        return dict(leaf.bit_generator.state)
    if isinstance(leaf, torch.Generator):
        return leaf.get_state()
    if isinstance(leaf, (list, deque, set)):
        return list(leaf)
    return leaf.item() if isinstance(leaf, np.generic) else leaf


def _restore(path: str, leaf: Any, assign: _Assign, saved: Any) -> None:
    if isinstance(leaf, torch.Tensor) and isinstance(saved, torch.Tensor):
        same = leaf.shape == saved.shape and leaf.dtype == saved.dtype
        if same and 0 not in leaf.stride():
            with torch.inference_mode(leaf.is_inference()):  # in place, for it may be a part of another tensor
                leaf.copy_(saved)
        else:
            assign(saved.to(leaf.device))
    elif isinstance(leaf, np.ndarray):
        if leaf.shape != tuple(saved.shape):
            raise StateMismatchError(f"'{path}' has shape {leaf.shape}, the saved state {tuple(saved.shape)}")
        if leaf.flags.writeable:
            leaf[...] = saved.numpy()
        elif not np.array_equal(leaf, saved.numpy(), equal_nan=leaf.dtype.kind in "fc"):
            raise StateMismatchError(f"'{path}' is an array that cannot be written to")
    elif isinstance(leaf, np.random.Generator):
        leaf.bit_generator.state = saved
    elif isinstance(leaf, torch.Generator):
        leaf.set_state(saved)
    elif isinstance(leaf, (list, deque)):
        leaf.clear()
        leaf.extend(saved)
    elif isinstance(leaf, set):
        leaf.clear()
        leaf.update(saved)
    else:
        assign(saved)


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


def load_rng_state(state: dict[str, Any]) -> None:
    """Write a state of :func:`rng_state` back."""
    torch.set_rng_state(state["torch"])
    name, keys, position, has_gauss, gauss = state["numpy"]
    np.random.set_state((name, keys.numpy().astype(np.uint32), position, has_gauss, gauss))  # noqa: NPY002
    version, numbers, gauss_next = state["python"]
    random.setstate((version, tuple(numbers.tolist()), gauss_next))
    if "cuda" in state and torch.cuda.is_available() and len(state["cuda"]) == torch.cuda.device_count():
        torch.cuda.set_rng_state_all(state["cuda"])
