"""The state of an environment: everything that its future depends on, by the names of managers, terms and entities."""

from __future__ import annotations

import copy
import dataclasses
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import torch

from lift_lab.managers import ManagerBase
from lift_lab.utils.errors import StateMismatchError
from lift_lab.utils.saved_state import copy_into
from lift_lab.utils.state_reader import StateReader
from lift_lab.utils.state_writer import StateWriter, saves_itself

if TYPE_CHECKING:
    from .manager_based_env import ManagerBasedEnv

STATE_VERSION = 5
"""Version of the form of a saved state."""


def named_objects(env: ManagerBasedEnv) -> dict[str, Any]:
    """The objects whose states make up that of an environment, such as ``"command_manager/object_pose"``, by name."""
    found: dict[str, Any] = {"env": env, "scene": env.scene}
    entities = {id(env.scene[name]): name for name in reversed(env.scene.keys())}  # one may have several names
    found |= {f"scene/{name}": env.scene[name] for name in reversed(entities.values())}
    for attribute, manager in vars(env).items():
        if isinstance(manager, ManagerBase):
            found[attribute] = manager
            found |= {f"{attribute}/{name}": term for name, term in manager.term_objects().items()}
    return found


def env_state(env: ManagerBasedEnv) -> dict[str, Any]:
    """Implementation of :meth:`ManagerBasedEnv.state_dict`."""
    objects = named_objects(env)
    physics = env.sim.physics
    writer = StateWriter(env.device, physics.storages(), {id(value): path for path, value in objects.items()})
    return {
        "version": STATE_VERSION,
        "num_envs": env.num_envs,
        "physics": physics.state_dict(),
        "objects": {
            path: writer.own(value, path) if saves_itself(value) and value is not env else writer.object(value, path)
            for path, value in objects.items()
        },
        "settings": env.changed_settings.state_dict(),
        "unsaved": [*writer.unsaved, *env.changed_settings.unsaved()],
    }


def load_env_state(env: ManagerBasedEnv, state: Any) -> None:
    """Implementation of :meth:`ManagerBasedEnv.load_state_dict`."""
    version = state.get("version", 1) if isinstance(state, dict) else None
    if type(version) is not int:
        raise StateMismatchError("the saved state is not valid: it has no version")
    if version != STATE_VERSION:
        raise StateMismatchError(f"the saved state has the form of version {version}, this is version {STATE_VERSION}")
    num_envs = state.get("num_envs")
    if type(num_envs) is not int:
        raise StateMismatchError("the saved state is not valid: it has no number of environments")
    if num_envs != env.num_envs:
        raise StateMismatchError(f"the saved state has {num_envs} environments, this run {env.num_envs}")
    physics = env.sim.physics
    physics.check_state_dict(state.get("physics"))
    saved, objects = state.get("objects"), named_objects(env)
    if not isinstance(saved, dict):
        raise StateMismatchError("the saved state is not valid: it has no objects")
    for path in sorted(objects.keys() ^ saved.keys()):
        raise StateMismatchError(f"'{path}' is only in the {'saved state' if path in saved else 'environment'}")
    reader = StateReader(env.device, physics.storages(), objects)
    for path, value in objects.items():
        reader.plan(value, saved[path], path)
    env.changed_settings.check_state_dict(state.get("settings"))
    physics.load_state_dict(state["physics"])
    env.changed_settings.load_state_dict(state["settings"])
    reader.apply()


class ChangedSettings:
    """Changes of configurations while the environment ran, mostly by curricula.

    Only those values are state: all others are as configured.
    """

    def __init__(self, configs: Callable[[], dict[str, Any]]):
        """Take note of the values as they are now.

        Args:
            configs: gives the configurations, by name.
        """
        self._configs = configs
        self._before = {path: _copy(value) for path, value in self._values().items()}
        self._functions = {path: value for path, _, _, value in _settings(configs(), callable)}

    def unsaved(self) -> list[str]:
        """Path and type of every function or class that was replaced: a file cannot name it."""
        now = {path: value for path, _, _, value in _settings(self._configs(), callable)}
        changed = [path for path, value in now.items() if self._functions.get(path) is not value]
        return [f"{_text(path)} ({type(now[path]).__name__})" for path in changed]

    def state_dict(self) -> dict[tuple, Any]:
        """Values that have changed, by path: a tuple of names, keys and indices."""
        return {path: _copy(value) for path, value in self._values().items() if self._has_changed(path, value)}

    def check_state_dict(self, state: Any) -> None:
        """Check that a state can be loaded.

        Raises:
            StateMismatchError: a path is of no configuration here, or not in the same place.
        """
        if not isinstance(state, dict) or not all(type(path) is tuple and path for path in state):
            raise StateMismatchError("the saved state is not valid: it has no settings")
        live = self._values()
        for path in self._before | state:
            holder = self._holder(path)
            new_index = isinstance(holder, list) and path not in live
            if (holder is None or new_index) and not any(path[:length] in state for length in range(1, len(path))):
                raise StateMismatchError(f"the saved state has changed the setting '{_text(path)}', which is not there")

    def load_state_dict(self, state: dict[tuple, Any]) -> None:
        """Change values to those of a state that :meth:`check_state_dict` accepts, and all others back."""
        wanted = self._before | state
        for path, holder, key, _ in reversed(list(_settings(self._configs()))):
            if any(path[:length] in wanted for length in range(1, len(path) + 1)):
                continue
            if isinstance(holder, (dict, list)):
                del holder[key]
            else:
                delattr(holder, key)
        for path, value in wanted.items():
            holder = self._holder(path)
            if holder is not None:  # else what holds it is replaced by the state
                _put(holder, path[-1], value)

    def _holder(self, path: tuple) -> Any:
        """What holds the value of a path: a dictionary, list or configuration; None if it is not there."""
        holder: Any = self._configs()
        for key in path[:-1]:
            try:
                holder = holder[key] if isinstance(holder, (dict, list)) else getattr(holder, key)
            except (KeyError, IndexError, TypeError, AttributeError):
                return None
        return holder if isinstance(holder, (dict, list)) or dataclasses.is_dataclass(holder) else None

    def _values(self) -> dict[tuple, Any]:
        return {path: value for path, _, _, value in _settings(self._configs())}

    def _has_changed(self, path: tuple, value: Any) -> bool:
        return path not in self._before or not _same(value, self._before[path])


_PLAIN = (type(None), bool, int, float, str)


def _is_plain(value: Any) -> bool:
    """Whether a value is a number or text, or a tuple, list or dictionary of nothing else."""
    if type(value) in (tuple, list):
        return all(map(_is_plain, value))
    if type(value) is dict:
        return all(isinstance(key, _PLAIN) and _is_plain(entry) for key, entry in value.items())
    return isinstance(value, _PLAIN)


def _is_value(entry: Any) -> bool:
    return isinstance(entry, torch.Tensor) or _is_plain(entry)


def _settings(
    value: Any, of_kind: Callable[[Any], bool] = _is_value, path: tuple = ()
) -> Iterator[tuple[tuple, Any, Any, Any]]:
    """Path, holder, key and value of what is of a kind in configurations: tensors, and what :func:`_is_plain` says."""
    if isinstance(value, dict):
        entries: Any = value.items()
    elif isinstance(value, list):
        entries = enumerate(value)
    else:
        entries = vars(value).items()
    for key, entry in entries:
        if of_kind(entry):
            yield (*path, key), value, key, entry
        elif isinstance(entry, (dict, list)) or (dataclasses.is_dataclass(entry) and not isinstance(entry, type)):
            yield from _settings(entry, of_kind, (*path, key))


def _text(path: tuple) -> str:
    return ".".join(map(str, path))


def _same(value: Any, other: Any) -> bool:
    if isinstance(value, torch.Tensor) or isinstance(other, torch.Tensor):
        alike = type(value) is type(other) and value.shape == other.shape
        return alike and torch.equal(value.cpu(), other.cpu())
    return type(value) is type(other) and repr(value) == repr(other)  # also NaN


def _copy(value: Any) -> Any:
    """A copy of a value, a tensor's on the CPU."""
    return value.detach().cpu().clone() if isinstance(value, torch.Tensor) else copy.deepcopy(value)


def _put(holder: Any, key: Any, value: Any) -> None:
    """Write a value that differs; tensors, lists and dictionaries in place if possible, since others may hold them."""
    entries = holder if isinstance(holder, (dict, list)) else vars(holder)
    old = entries[key] if isinstance(entries, list) else entries.get(key, dataclasses.MISSING)
    if _same(old, value):
        return
    if isinstance(old, torch.Tensor) and isinstance(value, torch.Tensor) and old.shape == value.shape:
        copy_into(old, value)
    elif isinstance(old, list) and isinstance(value, list):
        old[:] = _copy(value)
    elif isinstance(old, dict) and isinstance(value, dict):
        old.clear()
        old.update(_copy(value))
    elif isinstance(holder, (dict, list)):
        holder[key] = _copy(value)
    else:
        setattr(holder, key, _copy(value))
