"""The state of an environment: everything that its future depends on, by the names of managers, terms and entities."""

from __future__ import annotations

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

STATE_VERSION = 4
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
    """What has been changed in configurations while the environment ran, by curricula above all.

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
        return [f"{path} ({type(now[path]).__name__})" for path in changed]

    def state_dict(self) -> dict[str, Any]:
        """Values that have changed, by path."""
        return {path: _copy(value) for path, value in self._values().items() if self._has_changed(path, value)}

    def check_state_dict(self, state: Any) -> None:
        """Check that a state can be loaded.

        Raises:
            StateMismatchError: a path is of no configuration here.
        """
        if not isinstance(state, dict):
            raise StateMismatchError("the saved state is not valid: it has no settings")
        parents = {path.rpartition(".")[0] for path in self._before}
        for path in state:
            if str(path).rpartition(".")[0] not in parents:
                raise StateMismatchError(f"the saved state has changed the setting '{path}', which is not there")

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Change values to those of a state of :meth:`state_dict`, and all others back."""
        wanted = {path: self._before[path] for path in self.state_dict() if path in self._before} | state
        for path, holder, key, value in list(_settings(self._configs())):
            if path not in wanted:
                if path not in self._before:
                    holder.pop(key)  # an entry of a dictionary
                continue
            new = wanted.pop(path)
            if isinstance(value, torch.Tensor) and isinstance(new, torch.Tensor) and value.shape == new.shape:
                copy_into(value, new)
            else:
                _set(holder, key, _copy(new))
        holders = {path.rpartition(".")[0]: holder for path, holder, _, _ in _settings(self._configs())}
        for path, new in wanted.items():
            parent, _, key = path.rpartition(".")
            _set(holders[parent], key, new)

    def _values(self) -> dict[str, Any]:
        return {path: value for path, _, _, value in _settings(self._configs())}

    def _has_changed(self, path: str, value: Any) -> bool:
        if path not in self._before:
            return True
        before = self._before[path]
        if isinstance(value, torch.Tensor) or isinstance(before, torch.Tensor):
            same = type(value) is type(before) and value.shape == before.shape
            return not (same and torch.equal(value.cpu(), before))
        return type(value) is not type(before) or repr(value) != repr(before)  # also NaN


def _is_value(entry: Any) -> bool:
    return entry is None or isinstance(entry, (bool, int, float, str, torch.Tensor)) or _is_plain_tuple(entry)


def _settings(
    value: Any, of_kind: Callable[[Any], bool] = _is_value, path: str = ""
) -> Iterator[tuple[str, Any, Any, Any]]:
    """Path, holder, key and value of what is of a kind in configurations: numbers, texts, tuples and tensors."""
    if isinstance(value, dict):
        entries: Any = value.items()
    elif isinstance(value, list):
        entries = enumerate(value)
    else:
        entries = vars(value).items()
    for key, entry in entries:
        inner = f"{path}.{key}" if path else str(key)
        if of_kind(entry):
            yield inner, value, key, entry
        elif isinstance(entry, (dict, list)) or (dataclasses.is_dataclass(entry) and not isinstance(entry, type)):
            yield from _settings(entry, of_kind, inner)


def _is_plain_tuple(value: Any) -> bool:
    plain = (type(None), bool, int, float, str)
    return type(value) is tuple and all(isinstance(item, plain) or _is_plain_tuple(item) for item in value)


def _copy(value: Any) -> Any:
    return value.detach().cpu().clone() if isinstance(value, torch.Tensor) else value


def _set(holder: Any, key: Any, value: Any) -> None:
    if isinstance(holder, (dict, list)):
        holder[key] = value
    else:
        setattr(holder, key, value)
