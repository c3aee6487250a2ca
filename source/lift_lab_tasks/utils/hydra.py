"""Overrides of a task's configuration from a command line, in hydra's grammar.

- ``env.<path>=<value>``, ``agent.<path>=<value>``: set an entry. Entries of a list have numbers: ``target_frames.0``.
- ``env.<path>=null``: leave a term out.
- ``agent.<path>.<field>=<value>`` where the entry at ``<path>`` is null and may be a configuration: it gets one with
  the defaults of its class first, such as ``agent.algorithm.symmetry_cfg.use_data_augmentation=true``.
- ``+env.<path>=<value>``, ``~env.<path>``: add to or remove from a dictionary.
- ``env/<path>=<name>``: choose a preset that the task was registered with::

    kwargs={..., "presets": {"env.curriculum": {"step": "module:StepCfg", "linear": "module:LinearCfg"}}}

An override that lists several values is a sweep, see :mod:`lift_lab.app.multirun`.

hydra reads and composes the overrides. Only entries that they name are written into the configuration objects, so all
others (callables, tuples, slices, tensors) stay as they are. No folder is made, and the current directory stays.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
import sys
from collections.abc import Callable, Iterator, Sequence
from typing import Any, get_args

from hydra import compose as hydra_compose
from hydra import initialize
from hydra.core.config_store import ConfigStore
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, OverrideType
from hydra.errors import HydraException
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from lift_lab.app.cli import FlagSetting
from lift_lab.app.multirun import FLAGS, expand
from lift_lab.utils import update_class_from_dict
from lift_lab.utils.config_update import field_hints
from lift_lab.utils.errors import ConfigError, UnknownFieldError, quote, suggest
from lift_lab.utils.ranges import may_be_none

from .parse_cfg import ENV_CFG, load_cfg_from_registry, resolve_entry_point, task_kwargs

_STORE = "lift_lab_task"
_SEVERAL = "override '{}' lists several values: add --multirun to run once for each"


def compose(
    task_name: str,
    agent_cfg_entry_point: str | None,
    overrides: Sequence[str] = (),
    flags: Sequence[FlagSetting] = (),
) -> tuple[Any, Any]:
    """Configurations of a task with overrides applied.

    Args:
        task_name: id of the task.
        agent_cfg_entry_point: key of the agent's configuration, e.g. ``"rsl_rl_cfg_entry_point"``; None for none.
        overrides: in hydra's grammar, see the module.
        flags: entries that are set before the overrides, where the configurations have them.

    Returns:
        Environment and agent configuration; the latter None if there is none.

    Raises:
        NotFoundError: no such task or agent.
        ConfigError: an override cannot be read, names nothing, or has a value of the wrong type.
    """
    cfgs: dict[str, Any] = {"env": load_cfg_from_registry(task_name, ENV_CFG)}
    if agent_cfg_entry_point:
        cfgs["agent"] = load_cfg_from_registry(task_name, agent_cfg_entry_point)
    parsed = [_parse(text) for text in overrides]
    for override in parsed:
        if _is_preset(override):
            _apply_preset(cfgs, override, task_kwargs(task_name).get("presets", {}))
    for _, path, value in flags:
        if find_entry(cfgs, path)[0]:
            set_entry(cfgs, path, value)
    _apply(cfgs, [override for override in parsed if not _is_preset(override)])
    return cfgs["env"], cfgs.get("agent")


def given_paths(overrides: Sequence[str]) -> set[str]:
    """Paths of all entries that overrides set, also of those within a dictionary. A preset sets none.

    Args:
        overrides: in hydra's grammar, see the module.
    """
    found: set[str] = set()

    def add(path: str, value: Any) -> None:
        found.add(path)
        if isinstance(value, dict):
            for key, entry in value.items():
                add(f"{path}.{key}", entry)

    for override in map(_parse, overrides):
        if not _is_preset(override):
            add(override.key_or_group, override.value())
    return found


def find_entry(cfgs: dict[str, Any], path: str) -> tuple[bool, Any]:
    """Whether configurations have an entry, and its value.

    Args:
        cfgs: ``env`` and ``agent`` to their configurations.
        path: of the entry, such as ``env.scene.num_envs``.
    """
    node: Any = cfgs
    for name in path.split("."):
        if name not in _children(node):
            return False, None
        node = _get(node, name)
    return True, node


def set_entry(cfgs: dict[str, Any], path: str, value: Any) -> None:
    """Set an entry of configurations, unchecked.

    Args:
        cfgs: ``env`` and ``agent`` to their configurations.
        path: of the entry.
        value: its value.

    Raises:
        ConfigError: there is nothing that could have the entry.
    """
    *parents, name = path.split(".")
    owner = _find(cfgs, parents, path)
    if isinstance(owner, dict):
        owner[name] = value
    else:
        setattr(owner, name, value)


def hydra_task_config(task_name: str, agent_cfg_entry_point: str | None) -> Callable:
    """Decorator: call a function with the task's configurations, overridden by the command line's arguments.

    The function is called as ``func(env_cfg, agent_cfg, *args, **kwargs)`` (Isaac Lab's decorator of this name). With
    ``--multirun`` (or ``-m``) on the command line it is called once for each combination of the listed values. The
    results are then returned as a list.

    Args:
        task_name: id of the task.
        agent_cfg_entry_point: key of the agent's configuration.
    """

    def decorator(func: Callable) -> Callable:
        @functools.wraps(func)
        def wrapper(*args: Any, **kwargs: Any) -> Any:
            overrides = [text for text in sys.argv[1:] if text not in FLAGS]
            if len(overrides) == len(sys.argv) - 1:
                return func(*compose(task_name, agent_cfg_entry_point, overrides), *args, **kwargs)
            jobs = [compose(task_name, agent_cfg_entry_point, job) for job in expand(overrides)]
            return [func(env_cfg, agent_cfg, *args, **kwargs) for env_cfg, agent_cfg in jobs]

        return wrapper

    return decorator


# -- presets


def _is_preset(override: Override) -> bool:
    return override.type == OverrideType.CHANGE and "/" in override.key_or_group and override.package is None


def _apply_preset(cfgs: dict[str, Any], override: Override, presets: dict[str, dict[str, Any]]) -> None:
    text, group, choice = override.input_line, override.key_or_group, override.get_value_element_as_str()
    path = group.replace("/", ".")
    groups = {key.replace("/", "."): value for key, value in presets.items()}
    if path not in groups:
        choices = [key.replace(".", "/") for key in groups]
        raise ConfigError(f"override '{text}': no presets for '{group}'; {suggest(group, choices)}")
    if choice not in groups[path]:
        raise ConfigError(f"override '{text}': no preset '{choice}' for '{group}'; {suggest(choice, groups[path])}")
    set_entry(cfgs, path, resolve_entry_point(groups[path][choice], f"preset '{text}'"))


# -- overrides


def _apply(cfgs: dict[str, Any], overrides: Sequence[Override]) -> None:
    """Write overrides into the configurations."""
    if not overrides:
        return
    for override in overrides:
        _make_parents(cfgs, override.key_or_group.split("."))
        _check_key(cfgs, override)
    composed = _compose(cfgs, [_for_hydra(cfgs, override) for override in overrides])
    for override in overrides:
        keys = override.key_or_group.split(".")
        if override.type == OverrideType.DEL:
            _delete(_find(cfgs, keys[:-1], override.key_or_group), keys[-1], override)
            continue
        if override.value() == {} and override.type == OverrideType.CHANGE:
            _refuse_empty(cfgs, override)
        for path in list(_leaf_paths(_find(cfgs, keys[:-1], override.key_or_group), keys, override.value())):
            try:
                value = composed
                for key in path:  # one by one: a key of a dictionary may hold dots
                    value = value[int(key) if OmegaConf.is_list(value) else key]
                value = OmegaConf.to_container(value, resolve=True) if OmegaConf.is_config(value) else value
            except OmegaConfBaseException as error:
                raise ConfigError(f"override '{override.input_line}': {_first_line(error)}") from error
            _write(cfgs, path, value, override)


def _for_hydra(cfgs: dict[str, Any], override: Override) -> str:
    """The text of an override, for hydra, which adds to an empty dictionary only where it is told to."""
    text = override.input_line or ""
    if override.type != OverrideType.CHANGE or not isinstance(override.value(), dict):
        return text
    key = override.key_or_group
    return f"++{text}" if _find(cfgs, key.split("."), key) == {} else text


def _parse(text: str) -> Override:
    key, equals, _ = text.partition("=")
    if not equals and not text.startswith("~"):
        raise ConfigError(f"unexpected argument '{text}': overrides are written key=value, e.g. env.scene.num_envs=64")
    try:
        override = OverridesParser.create().parse_override(text)
    except HydraException as error:
        raise ConfigError(
            f"cannot read the override '{text}': {_first_line(error)}; quote values with special characters"
        ) from error
    if override.is_sweep_override():
        raise ConfigError(_SEVERAL.format(text))
    if key.lstrip("+~").split(".")[0] == "hydra":
        raise ConfigError(f"override '{text}': hydra's own settings have no meaning here")
    return override


def _compose(cfgs: dict[str, Any], texts: Sequence[str]) -> Any:
    """All entries with overrides applied, as hydra sees them."""
    ConfigStore.instance().store(name=_STORE, node=_plain(cfgs))
    GlobalHydra.instance().clear()
    try:
        with initialize(version_base="1.3", config_path=None):
            return hydra_compose(config_name=_STORE, overrides=list(texts))
    except (HydraException, OmegaConfBaseException) as error:
        raise ConfigError(f"cannot apply {quote(texts)}: {_first_line(error)}") from error


def _plain(value: Any) -> Any:
    """A configuration as hydra can hold it; what it cannot hold is named by its type."""
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, dict):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {key: _plain(entry) for key, entry in vars(value).items()}
    return f"<{type(value).__name__}>"


def _leaf_paths(owner: Any, path: list[str], value: Any) -> Iterator[list[str]]:
    """Paths of the values of an override; a dictionary sets each entry of a configuration or dictionary.

    It takes the place of anything else, and of an empty dictionary, as a whole.
    """
    current = _get(owner, path[-1])
    if isinstance(value, dict) and value and _children(current):
        for key, entry in value.items():
            yield from _leaf_paths(current, [*path, str(key)], entry)
    else:
        yield path


def _write(cfgs: dict[str, Any], path: list[str], value: Any, override: Override) -> None:
    """Set one entry, checked against what it replaces."""
    text = ".".join(path)
    owner = _find(cfgs, path[:-1], text)
    if override.type != OverrideType.CHANGE and isinstance(owner, dict) and path[-1] not in owner:
        owner[path[-1]] = value
        return
    current = _get(owner, path[-1])
    if isinstance(owner, (list, tuple)):
        names = quote(f"{text}.{name}" for name in _children(current)) or "the whole list"
        raise ConfigError(f"override '{override.input_line}': an entry of a list is not replaced; set {names}")
    if value is None and not _may_be_none(owner, path[-1], current):
        raise ConfigError(f"override '{override.input_line}': {text} needs a {type(current).__name__}, not null")
    if dataclasses.is_dataclass(current) and value is not None and not isinstance(value, dict):
        names = quote(f"{text}.{name}" for name in vars(current))
        raise ConfigError(f"override '{override.input_line}': {text} is a {type(current).__name__}; set one of {names}")
    try:
        update_class_from_dict(owner, {path[-1]: value}, ".".join(path[:-1]))
    except UnknownFieldError as error:
        raise ConfigError(_unknown(cfgs, path)) from error
    except ConfigError as error:
        raise ConfigError(f"override '{override.input_line}': {error}") from error


def _may_be_none(owner: Any, name: str, current: Any) -> bool:
    if dataclasses.is_dataclass(owner) and not may_be_none(type(owner), name):
        return False
    if isinstance(owner, dict) and dataclasses.is_dataclass(current) and type(current).__name__ == "SceneEntityCfg":
        return False  # an argument of a term
    if not isinstance(current, (bool, int, float, str, list, tuple, dict)):
        return True
    hint = None if isinstance(owner, dict) else field_hints(type(owner)).get(name)
    return hint is None or hint is Any or type(None) in get_args(hint)


def _delete(owner: Any, name: str, override: Override) -> None:
    if isinstance(owner, dict):
        del owner[name]
        return
    if dataclasses.is_dataclass(owner) and not may_be_none(type(owner), name):
        raise ConfigError(f"override '{override.input_line}': {name} is needed and cannot be removed")
    setattr(owner, name, None)


def _refuse_empty(cfgs: dict[str, Any], override: Override) -> None:
    """An empty dictionary merges nothing into one that has entries."""
    path = override.key_or_group
    names = _children(_find(cfgs, path.split("."), path))
    if names:
        text = quote(f"~{path}.{name}" for name in names)
        raise ConfigError(f"override '{override.input_line}': {{}} changes nothing; remove entries with {text}")


# -- paths


def _make_parents(cfgs: dict[str, Any], path: list[str]) -> None:
    """Give each entry above a path that is None a configuration, where its annotation names one class of them."""
    node: Any = cfgs
    for name in path[:-1]:
        if name not in _children(node):
            return
        if _get(node, name) is None and dataclasses.is_dataclass(node):
            options = [o for o in get_args(field_hints(type(node)).get(name)) if dataclasses.is_dataclass(o)]
            if len(options) != 1:
                return
            setattr(node, name, options[0]())  # pyright: ignore[reportCallIssue]
        node = _get(node, name)


def _check_key(cfgs: dict[str, Any], override: Override) -> None:
    """Complain about a path that leads nowhere, before hydra does."""
    path = override.key_or_group.split(".")
    node: Any = cfgs
    for depth, name in enumerate(path):
        last = depth == len(path) - 1
        if last and override.type in (OverrideType.ADD, OverrideType.FORCE_ADD) and isinstance(node, dict) and depth:
            return
        if name not in _children(node):
            raise ConfigError(_unknown(cfgs, path))
        node = _get(node, name)
    if len(path) == 1:
        raise ConfigError(f"override '{override.input_line}': only entries below {path[0]} can be changed or removed")
    if override.type == OverrideType.CHANGE:
        _check_entries(cfgs, path, node, override.value())


def _check_entries(cfgs: dict[str, Any], path: list[str], node: Any, value: Any) -> None:
    """Complain about entries of a dictionary that lead nowhere; an empty dictionary takes any."""
    known = _children(node)
    if not isinstance(value, dict) or not known:
        return
    for key, entry in value.items():
        if str(key) not in known:
            raise ConfigError(_unknown(cfgs, [*path, str(key)]))
        _check_entries(cfgs, [*path, str(key)], _get(node, str(key)), entry)


def _unknown(cfgs: dict[str, Any], path: list[str]) -> str:
    """Message for a path that leads nowhere, with the nearest paths that lead somewhere."""
    text = ".".join(path)
    node: Any = cfgs
    depth = 0
    while depth < len(path) and path[depth] in _children(node):
        node = _get(node, path[depth])
        depth += 1
    rest = path[depth + 1 :]
    prefix = ".".join(path[:depth])
    close = difflib.get_close_matches(path[depth], _children(node), n=3, cutoff=0.6) if depth < len(path) else []
    near = [".".join(part for part in (prefix, name) if part) for name in close]
    near = [".".join([base, *rest]) if find_entry(cfgs, ".".join([base, *rest]))[0] else base for base in near]
    if not near:
        # Right names at another place, as rewards.x.weight for env.rewards.x.weight
        everything = list(_all_paths(cfgs))
        for length in range(len(path), 0, -1):
            tail = "." + ".".join(path[-length:])
            near = [known for known in everything if known.endswith(tail)][:3]
            if near:
                break
    if near:
        return f"unknown override key '{text}'; did you mean {quote(near)}?"
    here = [".".join(part for part in (prefix, name) if part) for name in _children(node)]
    return f"unknown override key '{text}'; {suggest(text, here)}"


def _children(node: Any) -> list[str]:
    if isinstance(node, dict):
        return [str(key) for key in node]
    if dataclasses.is_dataclass(node) and not isinstance(node, type):
        return list(vars(node))
    if isinstance(node, (list, tuple)) and any(_children(entry) for entry in node):
        return [str(i) for i in range(len(node))]
    return []


def _get(node: Any, name: str) -> Any:
    if isinstance(node, (list, tuple)):
        return node[int(name)] if name.isdigit() and int(name) < len(node) else None
    return node.get(name) if isinstance(node, dict) else getattr(node, name, None)


def _find(cfgs: dict[str, Any], path: list[str], full: str) -> Any:
    node: Any = cfgs
    for name in path:
        if name not in _children(node):
            raise ConfigError(_unknown(cfgs, full.split(".")))
        node = _get(node, name)
    return node


def _all_paths(node: Any, prefix: str = "") -> Iterator[str]:
    for name in _children(node):
        path = f"{prefix}.{name}" if prefix else name
        yield path
        yield from _all_paths(_get(node, name), path)


def _first_line(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__
