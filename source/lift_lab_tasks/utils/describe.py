"""A task as a person reads it: its spaces, every manager's terms, its scene, its physics, and what has no effect."""

from __future__ import annotations

import inspect
import math
from collections.abc import Iterable, Sequence
from typing import Any

from rich.table import Column, Table
from rich.text import Text

from lift_lab.managers import SceneEntityCfg

_NOT_SHOWN = {"class_type", "func", "params", "weight", "mode", "debug_vis", "ranges", "noise", "modifiers"}
"""Fields of term configs that have a column of their own or say nothing to a reader."""


def describe(task: str, overrides: Sequence[str] = ()) -> list[Table]:
    """Build one environment of a task and describe its parts.

    Args:
        task: id of the task.
        overrides: of its configuration, in hydra's grammar.

    Returns:
        Tables to print.

    Raises:
        NotFoundError: no such task.
        ConfigError: an override or the configuration is wrong.
    """
    import gymnasium as gym

    from .hydra import compose
    from .parse_cfg import task_kwargs

    cfg, _ = compose(task, None, overrides)
    num_envs, configured_device = cfg.scene.num_envs, cfg.sim.device
    cfg.scene.num_envs, cfg.sim.device, cfg.sim.num_threads = 1, "cpu", 1
    physics, cfg.sim.physics = cfg.sim.physics, None  # the default of the CPU
    cfg.seed = cfg.seed if cfg.seed is not None else 0
    env: Any = gym.make(task, cfg=cfg)
    try:
        inner = env.unwrapped
        inner.reset()
        head = _overview(task, task_kwargs(task), inner, num_envs)
        return [head, *_manager_tables(inner), _scene(inner), _physics(inner, physics, configured_device), _ignored()]
    finally:
        env.close()


def _overview(task: str, kwargs: dict[str, Any], env: Any, num_envs: int) -> Table:
    agents = [k.removesuffix("_cfg_entry_point") for k in kwargs if k.endswith("_cfg_entry_point") and k[:4] != "env_"]
    presets = [
        f"{group.replace('.', '/')}={name}" for group, names in kwargs.get("presets", {}).items() for name in names
    ]
    spaces = [(f"observation '{k}'", _space(v)) for k, v in env.single_observation_space.spaces.items()]
    rows = [
        ("configuration", type(env.cfg).__module__ + ":" + type(env.cfg).__name__),
        ("agents", ", ".join(agents) or "-"),
        ("presets", ", ".join(presets) or "-"),
        ("success", _value(kwargs.get("success")) if kwargs.get("success") else "-"),
        ("environments", f"{num_envs} as configured (fewer on a CPU), {env.cfg.scene.env_spacing:g} m apart"),
        ("episode", f"{env.max_episode_length_s:g} s = {env.max_episode_length} steps of {env.step_dt:g} s"),
        *spaces,
        ("action", _space(env.single_action_space)),
    ]
    return _table(task, ("", ""), rows)


def _space(space: Any) -> str:
    if hasattr(space, "spaces"):
        return ", ".join(f"{name} {_space(part)}" for name, part in space.spaces.items())
    low, high = float(space.low.min()), float(space.high.max())
    bounds = "" if math.isinf(low) and math.isinf(high) else f" in [{low:g}, {high:g}]"
    return f"{' x '.join(map(str, space.shape))} numbers{bounds}"


def _manager_tables(env: Any) -> list[Table]:
    tables = []
    observations = env.observation_manager
    for group, names in observations.active_terms.items():
        dims, cfgs = observations.group_obs_term_dim[group], observations.group_obs_term_cfgs[group]
        rows = [(n, _shape(d), _function(c), _params(c), _noise(c)) for n, d, c in zip(names, dims, cfgs, strict=True)]
        tables.append(_table(f"Observations '{group}'", ("term", "shape", "function", "parameters", "noise"), rows))
    actions = [env.action_manager.get_term(name) for name in env.action_manager.active_terms]
    rows = [
        (name, term.action_dim, type(term).__name__, _fields(term.cfg))
        for name, term in zip(env.action_manager.active_terms, actions, strict=True)
    ]
    tables.append(_table("Actions", ("term", "size", "kind", "settings"), rows))
    commands = [(name, env.command_manager.get_term(name)) for name in env.command_manager.active_terms]
    rows = [(name, type(term).__name__, _ranges(term.cfg), _fields(term.cfg)) for name, term in commands]
    tables.append(_table("Commands", ("term", "kind", "drawn from", "settings"), rows))
    manager = env.reward_manager
    rows = [(n, f"{c.weight:g}", _function(c), _params(c)) for n, c in _terms(manager)]
    tables.append(_table("Rewards", ("term", "weight", "function", "parameters"), rows))
    rows = [
        (n, "time out" if c.time_out else "terminal", _function(c), _params(c))
        for n, c in _terms(env.termination_manager)
    ]
    tables.append(_table("Terminations", ("term", "kind", "function", "parameters"), rows))
    rows = [(n, c.reduce, _function(c), _params(c)) for n, c in _terms(env.metrics_manager)]
    tables.append(_table("Metrics", ("term", "reduce", "function", "parameters"), rows))
    events = env.event_manager
    rows = [
        (name, mode, _function(cfg), _params(cfg))
        for mode, names in events.active_terms.items()
        for name, cfg in ((name, events.get_term_cfg(name)) for name in names)
    ]
    tables.append(_table("Events", ("term", "mode", "function", "parameters"), rows))
    rows = [(n, _function(c), _params(c)) for n, c in _terms(env.curriculum_manager)]
    tables.append(_table("Curriculum", ("term", "function", "parameters"), rows))
    return [table for table in tables if table.row_count]


def _scene(env: Any) -> Table:
    rows = []
    for name in list(env.scene.keys()):
        entity = env.scene[name]
        spawn = getattr(getattr(entity, "cfg", entity), "spawn", None)
        file = str(getattr(spawn, "usd_path", "") or "").rsplit("/", 1)[-1]
        parts = [
            f"{count} {word if count == 1 else words}"
            for key, word, words in (("num_joints", "joint", "joints"), ("num_bodies", "body", "bodies"))
            if isinstance(count := getattr(entity, key, None), int)
        ]
        rows.append((name, type(entity).__name__, file or "-", ", ".join(parts) or "-"))
    return _table("Scene", ("name", "kind", "file", "size"), rows)


def _physics(env: Any, kind: str | None, device: str) -> Table:
    sim, model = env.cfg.sim, env.sim.model
    rows = [
        ("engine", kind or "native on a CPU, warp on CUDA"),
        ("device", device),
        ("physics step", f"{sim.dt:g} s, {env.cfg.decimation} in each environment step"),
        ("gravity", f"{_value(tuple(sim.gravity))} m/s^2"),
        *((name, _value(value)) for name, value in vars(sim.mujoco).items() if value is not None),
        ("model", f"{model.nq} positions, {model.nv} velocities, {model.nu} actuators, {model.ngeom} geoms"),
    ]
    return _table("Physics", ("setting", "value"), rows)


def _ignored() -> Table:
    from lift_lab.sim.ignored import ignored_settings

    rows = sorted(ignored_settings().items()) or [("none", "")]
    return _table("Ignored settings", ("setting", "why it has no effect"), rows)


# -- cells


def _terms(manager: Any) -> list[tuple[str, Any]]:
    return [(name, manager.get_term_cfg(name)) for name in manager.active_terms]


def _table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> Table:
    headings = (Column(heading, overflow="fold") for heading in columns)  # names that are too long are not cut
    table = Table(*headings, title=title, title_justify="left", title_style="bold", show_header=any(columns))
    for row in rows:
        table.add_row(*(Text(str(cell)) for cell in row))
    return table


def _function(cfg: Any) -> str:
    return _value(cfg.func)


def _params(cfg: Any) -> str:
    return ", ".join(f"{name}={_value(value)}" for name, value in cfg.params.items()) or "-"


def _noise(cfg: Any) -> str:
    if cfg.noise is None:
        return "-"
    values = ", ".join(f"{k}={_value(v)}" for k, v in vars(cfg.noise).items() if k != "func" and v is not None)
    return f"{type(cfg.noise).__name__.removesuffix('Cfg')}({values})"


def _ranges(cfg: Any) -> str:
    ranges = getattr(cfg, "ranges", None)
    return ", ".join(f"{name}={_value(value)}" for name, value in vars(ranges).items()) if ranges is not None else "-"


def _fields(cfg: Any) -> str:
    shown = {k: v for k, v in vars(cfg).items() if k not in _NOT_SHOWN and not k.endswith("visualizer_cfg")}
    return ", ".join(f"{name}={_value(value)}" for name, value in shown.items() if value is not None) or "-"


def _shape(dims: Any) -> str:
    return " x ".join(str(size) for size in dims)


def _value(value: Any) -> str:
    """A value in few characters."""
    if isinstance(value, SceneEntityCfg):
        names = [n for n in (value.joint_names, value.body_names) if n]
        return f"{value.name}[{', '.join(_value(n) for n in names)}]" if names else value.name
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, (tuple, list)):
        return f"({', '.join(_value(part) for part in value)})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_value(part)}" for key, part in value.items()) + "}"
    if inspect.isclass(value) or inspect.isroutine(value):
        return value.__name__
    if isinstance(value, (str, int, bool)) or value is None:
        return str(value)
    if hasattr(value, "__dataclass_fields__"):
        inside = ", ".join(f"{k}={_value(v)}" for k, v in vars(value).items() if not callable(v) and v is not None)
        return f"{type(value).__name__.removesuffix('Cfg')}({inside})"
    return type(value).__name__
