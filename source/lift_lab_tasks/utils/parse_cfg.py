"""Registered tasks, their configurations, and the checkpoints of their runs."""

from __future__ import annotations

import importlib
import pkgutil
import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import gymnasium as gym

from lift_lab.utils.errors import ConfigError, FileError, NotFoundError, suggest

ENV_CFG = "env_cfg_entry_point"
"""Key under which a task is registered with its environment's configuration."""

CPU_NUM_ENVS = 1024
"""Environments on a CPU for a task that does not say otherwise."""


def registered_tasks() -> list[str]:
    """Ids of the tasks that are configured in this way, in alphabetical order."""
    return sorted(name for name, spec in gym.registry.items() if ENV_CFG in spec.kwargs)


def task_kwargs(task_name: str) -> dict[str, Any]:
    """Return the keyword arguments with which a task was registered.

    Args:
        task_name: id. With a ``module:`` in front, as in gymnasium, that module is imported first. It is also looked
            for in the current folder, as ``python -m`` does.

    Raises:
        NotFoundError: no such module or task; names the nearest.
    """
    module, _, name = task_name.rpartition(":")
    if module:
        import_user_module(module)
    if name not in gym.registry or ENV_CFG not in gym.registry[name].kwargs:
        # Those of the module, which were registered last, come first.
        tasks = [known for known, spec in reversed(gym.registry.items()) if ENV_CFG in spec.kwargs]
        hint = "" if module else "; a task of your own needs its module: MODULE:ID"
        raise NotFoundError(f"unknown task '{name}'; {suggest(name, tasks if module else registered_tasks())}{hint}")
    return dict(gym.registry[name].kwargs)


def import_user_module(module: str) -> None:
    """Import a module that a user names. The current folder is put on the module path, as ``python -m`` does.

    Args:
        module: name of a module or package, such as ``my_tasks`` or ``my_tasks.reach``.

    Raises:
        NotFoundError: there is no such module, or it imports one that does not exist.
    """
    here = str(Path.cwd())
    if here not in sys.path:
        sys.path.insert(0, here)
    try:
        missing = None if all(part.isidentifier() for part in module.split(".")) else module
        if missing is None:
            importlib.import_module(module)
    except ModuleNotFoundError as error:
        missing = error.name or ""
        if missing != module and not module.startswith(f"{missing}."):
            raise NotFoundError(f"cannot import the module '{module}': {error}") from error
    if missing is None:
        return
    if missing.endswith(".py"):
        raise NotFoundError(f"no module '{missing}'; did you mean '{missing.removesuffix('.py')}'?")
    package = missing.rpartition(".")[0]
    names = [info.name for info in pkgutil.iter_modules(getattr(sys.modules.get(package), "__path__", [here]))]
    place = f"the package '{package}'" if package in sys.modules else f"'{here}' or among the installed packages"
    near = suggest(missing.rpartition(".")[2], names) if names else "this folder has no modules"
    wanted = "" if missing == module else f"cannot import '{module}': "
    raise NotFoundError(f"{wanted}no module '{missing}' in {place}; {near}")


def load_cfg_from_registry(task_name: str, entry_point_key: str) -> Any:
    """A new instance of a configuration that a task was registered with (Isaac Lab's function of this name).

    Args:
        task_name: id of the task.
        entry_point_key: e.g. ``"env_cfg_entry_point"`` or ``"rsl_rl_cfg_entry_point"``. The value may be
            ``"module:Class"``, a class, an instance, or a path or ``"module:file"`` that ends in ``.yaml``.

    Returns:
        The configuration; a dictionary if it is a YAML file.

    Raises:
        NotFoundError: no such task, or it was registered without this key.
    """
    kwargs = task_kwargs(task_name)
    entry = kwargs.get(entry_point_key)
    if entry is None:
        choices = [key for key in kwargs if key.endswith("_entry_point")]
        raise NotFoundError(f"task '{task_name}' has no '{entry_point_key}'; {suggest(entry_point_key, choices)}")
    if isinstance(entry, str) and entry.endswith(".yaml"):
        return _load_yaml(entry)
    return resolve_entry_point(entry, f"task '{task_name}'")


def resolve_entry_point(entry: Any, owner: str) -> Any:
    """The object that ``"module:name"`` stands for; called if it is a class or function.

    Raises:
        NotFoundError: the module or the name does not exist.
    """
    found = entry
    if isinstance(entry, str):
        module_name, _, name = entry.partition(":")
        try:
            module = importlib.import_module(module_name)
        except ModuleNotFoundError as error:
            raise NotFoundError(f"{owner}: cannot import '{module_name}': {error}") from error
        if not hasattr(module, name):
            raise NotFoundError(f"{owner}: '{module_name}' has no '{name}'; {suggest(name, vars(module))}")
        found = getattr(module, name)
    return found() if callable(found) else found.copy() if hasattr(found, "copy") else found


def _load_yaml(entry: str) -> dict:
    from lift_lab.utils.io import load_yaml

    path = Path(entry)
    if not path.is_file() and ":" in entry:
        module_name, file_name = entry.split(":")
        path = Path(importlib.import_module(module_name).__file__ or "").parent / file_name
    return load_yaml(path)


def parse_env_cfg(
    task_name: str, device: str | None = "auto", num_envs: int | None = None, use_fabric: bool | None = None
) -> Any:
    """Environment configuration of a task for a device (Isaac Lab's function of this name).

    Args:
        task_name: id of the task.
        device: torch device; ``auto``, or None, takes a GPU where there is one.
        num_envs: number of environments; None for what suits the device (:func:`num_envs_for_device`).
        use_fabric: Isaac Lab's; reported as ignored by the simulation if it is False.

    Raises:
        ConfigError: the task is configured by a YAML file.
    """
    cfg = load_cfg_from_registry(task_name, ENV_CFG)
    if isinstance(cfg, dict):
        raise ConfigError(f"task '{task_name}' is configured by a dictionary; a configuration class is needed")
    cfg.sim.device = device if device is not None else "auto"
    if use_fabric is not None:
        cfg.sim.use_fabric = use_fabric
    cfg.scene.num_envs = num_envs if num_envs is not None else num_envs_for_device(task_name, cfg)
    return cfg


def num_envs_for_device(task_name: str, cfg: Any) -> int:
    """Return the number of environments for the device of ``cfg``: as configured on a GPU, at most ``cpu_num_envs`` on
    a CPU."""
    from lift_lab.sim.simulation_context import resolve_device

    if resolve_device(cfg.sim.device) != "cpu":
        return cfg.scene.num_envs
    return min(cfg.scene.num_envs, task_kwargs(task_name).get("cpu_num_envs", CPU_NUM_ENVS))


def get_checkpoint_path(
    log_path: str | Path,
    run_dir: str = ".*",
    checkpoint: str = r"model_\d+\.pt",
    other_dirs: Sequence[str] | None = None,
    sort_alpha: bool = True,
    prefer: Callable[[Path], bool] | None = None,
    accept: Callable[[Path], bool] | None = None,
) -> str:
    """Path of the newest checkpoint that matches (Isaac Lab's function of this name).

    Args:
        log_path: folder of the experiment, with one folder for each run.
        run_dir: regular expression of the run; among matches with a matching checkpoint the last is taken.
        checkpoint: regular expression of the file; among matches the last in natural order is taken.
        other_dirs: folders between the run and the file.
        sort_alpha: whether runs are ordered by name; else by time of change.
        prefer: function that marks runs which come first, regardless of their age; None for none.
        accept: function that accepts a matching file; if it does not, the file before is tried. None takes all.

    Raises:
        FileError: nothing matches; names what there is.
        ConfigError: not a regular expression.
    """
    folder = Path(log_path)
    if not folder.is_dir():
        raise FileError(f"no runs in '{folder}': train first, or pass the path of a checkpoint")
    runs = sorted(entry for entry in folder.iterdir() if entry.is_dir())
    matching = [run for run in runs if _matches(run_dir, run.name)]
    matching.sort(key=(lambda run: run.name) if sort_alpha else (lambda run: run.stat().st_mtime))
    if not matching:
        raise FileError(f"no run in '{folder}' matches '{run_dir}'; {suggest(run_dir, [run.name for run in runs])}")
    if prefer is not None:
        matching.sort(key=prefer)
    refused = False
    for run in reversed(matching):
        place = run.joinpath(*(other_dirs or ()))
        names = [entry.name for entry in place.iterdir() if entry.is_file()] if place.is_dir() else []
        found = sorted((name for name in names if _matches(checkpoint, name)), key=_natural)
        for name in reversed(found):
            if accept is None or accept(place / name):
                return str(place / name)
            refused = True
    if refused:
        raise FileError(f"every checkpoint in '{folder}' that matches '{checkpoint}' is damaged")
    # Beside runs there are folders without any checkpoint, such as that of a shipped policy's exports.
    places = [run.joinpath(*(other_dirs or ())) for run in matching]
    newest = next((place for place in reversed(places) if any(place.glob("model_*.pt"))), places[-1])
    names = sorted((entry.name for entry in newest.glob("model_*.pt")), key=_natural)
    raise FileError(f"no checkpoint in '{newest}' matches '{checkpoint}'; {suggest(checkpoint, names)}")


def _matches(expression: str, name: str) -> bool:
    try:
        return re.fullmatch(expression, name) is not None
    except re.error as error:
        raise ConfigError(f"'{expression}' is not a regular expression: {error}") from error


def _natural(name: str) -> list[tuple[int, int, str]]:
    """Sort key under which model_10 comes after model_9."""
    return [(1, int(part), "") if part.isdigit() else (0, 0, part) for part in re.split(r"(\d+)", name)]
