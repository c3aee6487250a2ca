"""Events: changes of the simulation, made when their mode is applied.

The environment applies ``prestartup`` once before the simulation starts, and ``startup`` once after. It applies
``reset`` to the environments that reset, and ``interval`` at every step. Your own code applies any other mode.
"""

from __future__ import annotations

import inspect
import logging
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.assets import AssetBase
from lift_lab.sensors import SensorBase
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.indexing import fill_rows

from ._table import render_table
from .manager_base import EnvIds, ManagerBase, ManagerTermBase, as_env_id_tensor
from .manager_term_cfg import EventTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv

logger = logging.getLogger(__name__)

_DUE_S = 1e-6
"""A timer with less left than this is due: it absorbs the rounding of repeated subtraction."""


class EventManager(ManagerBase):
    """Applies event terms by mode.

    The manager may be built before the simulation starts, for the sake of ``prestartup`` terms. Then scene entities
    are resolved, and class terms of other modes built, by :meth:`resolve_terms`, at the latest when such a mode is
    first applied. Source: Isaac Lab's ``EventManager``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_mode_term_names", "_mode_term_cfgs", "_mode_class_term_cfgs", "_unbound"}
    )

    def __init__(self, cfg: object, env: ManagerBasedEnv):
        """Check the terms; bind them to the scene if the simulation has started.

        Raises:
            ConfigError: a mode, an interval or a step count is missing or wrong.
        """
        super().__init__(cfg, env)

    def __str__(self) -> str:
        tables = []
        for mode, names in self._mode_term_names.items():
            columns, rows = ["Index", "Name"], [[i, name] for i, name in enumerate(names)]
            if mode == "interval":
                columns.append("Interval time range (s)")
                for row, cfg in zip(rows, self._mode_term_cfgs[mode], strict=True):
                    row.append(cfg.interval_range_s)
            tables.append(render_table(f"Active Event Terms in Mode: '{mode}'", columns, rows))
        count = sum(len(names) for names in self._mode_term_names.values())
        return f"<EventManager> contains {count} active terms.\n{''.join(tables)}"

    @property
    def active_terms(self) -> dict[str, list[str]]:
        """Names of the terms by mode."""
        return self._mode_term_names

    def term_objects(self) -> dict[str, Any]:
        cfgs = {name: self.get_term_cfg(name) for names in self._mode_term_names.values() for name in names}
        return {name: cfg.func for name, cfg in cfgs.items() if isinstance(cfg.func, ManagerTermBase)}

    @property
    def available_modes(self) -> list[str]:
        """Modes that have a term."""
        return list(self._mode_term_names)

    def _prepare_terms(self) -> None:
        self._mode_term_names: dict[str, list[str]] = {}
        self._mode_term_cfgs: dict[str, list[EventTermCfg]] = {}
        self._mode_class_term_cfgs: dict[str, list[EventTermCfg]] = {}
        self._interval_term_time_left: list[torch.Tensor] = []
        self._reset_term_last_triggered_step_id: list[torch.Tensor] = []
        self._reset_term_last_triggered_once: list[torch.Tensor] = []
        self._unbound: list[tuple[str, EventTermCfg]] = []
        for name, cfg in self._term_items(EventTermCfg, self.cfg):
            self._check_event(name, cfg)
            self._mode_term_names.setdefault(cfg.mode, []).append(name)
            self._mode_term_cfgs.setdefault(cfg.mode, []).append(cfg)
            class_terms = self._mode_class_term_cfgs.setdefault(cfg.mode, [])
            if inspect.isclass(cfg.func) or isinstance(cfg.func, ManagerTermBase):
                class_terms.append(cfg)
            self._unbound.append((name, cfg))
            if cfg.mode == "interval":
                num_timers, device = (1, "cpu") if cfg.is_global_time else (self.num_envs, self.device)
                self._interval_term_time_left.append(_draw_interval(cfg, num_timers, device))
            elif cfg.mode == "reset":
                last_step = torch.zeros(self.num_envs, dtype=torch.int32, device=self.device)
                self._reset_term_last_triggered_step_id.append(last_step)
                self._reset_term_last_triggered_once.append(last_step.bool())
        if getattr(self._env.sim, "is_started", True):
            self.resolve_terms()
        else:  # prestartup terms act on the scene before it has indices
            for cfg in self._mode_class_term_cfgs.get("prestartup", []):
                if inspect.isclass(cfg.func):
                    self._build_term(cfg)

    def prepare_model(self) -> None:
        """Let class terms change the scene's spec before it is compiled: :meth:`ManagerTermBase.prepare_model`."""
        for class_terms in self._mode_class_term_cfgs.values():
            for cfg in class_terms:
                cfg.func.prepare_model(self._env, **cfg.params)  # type: ignore[union-attr]

    def resolve_terms(self) -> None:
        """Bind the terms that waited for the simulation to start to the scene. A second call does nothing.

        Raises:
            ConfigError: a scene entity cannot be resolved.
        """
        unbound, self._unbound = self._unbound, []
        for name, cfg in unbound:
            self._bind_term(name, cfg)

    def _check_event(self, name: str, cfg: EventTermCfg) -> None:
        """What can be wrong with a term's own fields, and its function."""
        owner = self._owner(name)
        if not isinstance(cfg.mode, str):
            raise ConfigError(f"{owner}: mode must be a string such as 'reset', not {cfg.mode!r}")
        span = cfg.interval_range_s
        if cfg.mode == "interval" and span is None:
            raise ConfigError(f"{owner}: mode 'interval' needs interval_range_s, the seconds between applications")
        if cfg.mode == "interval" and span is not None and not 0.0 <= span[0] <= span[1]:
            raise ConfigError(f"{owner}: interval_range_s {span} is no range of seconds")
        if cfg.min_step_count_between_reset < 0:
            raise ConfigError(f"{owner}: min_step_count_between_reset must not be negative")
        if cfg.mode != "reset" and cfg.min_step_count_between_reset > 0:
            logger.warning("%s: min_step_count_between_reset does nothing in mode '%s'", owner, cfg.mode)
        self._check_term(name, cfg, min_argc=2)

    def apply(
        self,
        mode: str,
        env_ids: EnvIds = None,
        dt: float | None = None,
        global_env_step_count: int | None = None,
    ) -> None:
        """Apply the terms of a mode, in declaration order.

        Args:
            mode: The mode; one without terms is only warned of.
            env_ids: The environments; None means all. Not for ``interval``, whose timers choose them.
            dt: Seconds since the last call; only for ``interval``.
            global_env_step_count: Environment steps so far; only for ``reset``.

        Raises:
            ValueError: an argument that the mode needs is missing, or one it cannot take is given.
        """
        if mode not in self._mode_term_names:
            logger.warning("no event term has mode '%s': %s", mode, suggest(mode, self.available_modes))
            return
        if self._unbound and mode != "prestartup":
            self.resolve_terms()
        if mode == "interval":
            if dt is None:
                raise ValueError("mode 'interval' needs the environment step dt in seconds")
            if env_ids is not None:
                raise ValueError("mode 'interval' takes no env_ids: the timers choose the environments")
            self._apply_interval(dt)
        elif mode == "reset":
            if global_env_step_count is None:
                raise ValueError("mode 'reset' needs global_env_step_count, the environment steps so far")
            self._apply_reset(env_ids, global_env_step_count)
        else:
            for name, cfg in zip(self._mode_term_names[mode], self._mode_term_cfgs[mode], strict=True):
                try:
                    self._call(cfg, env_ids)
                except AttributeError as error:
                    if mode != "prestartup" or not isinstance(error.obj, (AssetBase, SensorBase)):
                        raise
                    raise ConfigError(
                        f"{self._owner(name)}: its function needs the simulation, which mode 'prestartup' comes "
                        f"before; use mode 'startup'"
                    ) from error

    def _call(self, cfg: EventTermCfg, env_ids: Any) -> None:
        cfg.func(self._env, env_ids, **cfg.params)  # type: ignore[operator]

    def _apply_interval(self, dt: float) -> None:
        for index, cfg in enumerate(self._mode_term_cfgs["interval"]):
            time_left = self._interval_term_time_left[index]
            time_left -= dt
            due = self._env.prefetched.pop(("interval event", index), None)
            if due is None:
                due = (time_left < _DUE_S).nonzero().flatten()
            if len(due) == 0:
                continue
            time_left[due] = _draw_interval(cfg, len(due), time_left.device)
            self._call(cfg, None if cfg.is_global_time else due)

    def masks(self, dt: float, ended: torch.Tensor) -> dict[Any, torch.Tensor]:
        """To which environments the next call of mode ``interval`` will apply its terms.

        Without terms that have one timer for all environments, which the host has, and terms that may be due right
        after a reset.
        """
        return {
            ("interval event", index): (self._interval_term_time_left[index] - dt < _DUE_S) & ~ended
            for index, cfg in enumerate(self._mode_term_cfgs.get("interval", []))
            if not cfg.is_global_time and cfg.interval_range_s[0] >= dt + 2 * _DUE_S  # type: ignore[index]
        }

    def _apply_reset(self, env_ids: EnvIds, step: int) -> None:
        ids: Any = slice(None) if env_ids is None else env_ids
        for index, cfg in enumerate(self._mode_term_cfgs["reset"]):
            last_step = self._reset_term_last_triggered_step_id[index]
            chosen = ids
            if cfg.min_step_count_between_reset > 0:
                fired_once = self._reset_term_last_triggered_once[index]
                candidates = as_env_id_tensor(ids, self.num_envs, self.device)
                last = last_step[candidates]
                due = step - last >= cfg.min_step_count_between_reset
                chosen = candidates[due | ((last == 0) & ~fired_once[candidates])]
                if len(chosen) == 0:
                    continue
                fired_once[chosen] = True
                fill_rows(last_step, chosen, step)
            self._call(cfg, chosen)

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Reset class terms, and draw the interval timers again except global ones. Logs nothing."""
        if self._unbound:
            self.resolve_terms()
        for class_terms in self._mode_class_term_cfgs.values():
            for cfg in class_terms:
                cfg.func.reset(env_ids=env_ids)  # type: ignore[union-attr]
        for index, cfg in enumerate(self._mode_term_cfgs.get("interval", [])):
            if not cfg.is_global_time:
                ids = as_env_id_tensor(env_ids, self.num_envs, self.device)
                self._interval_term_time_left[index][ids] = _draw_interval(cfg, len(ids), self.device)
        return {}

    def get_term_cfg(self, term_name: str) -> EventTermCfg:
        """The live config of a term: edits take effect at the next call.

        Raises:
            ConfigError: no term has this name.
        """
        mode, index = self._find(term_name)
        return self._mode_term_cfgs[mode][index]

    def set_term_cfg(self, term_name: str, cfg: EventTermCfg) -> None:
        """Replace a term's config by another of the same mode, resolving it if it is a new one.

        Raises:
            ConfigError: no term has this name, the mode differs, or the config cannot be resolved.
            TypeError: the config is of another manager.
        """
        mode, index = self._find(term_name)
        old = self._mode_term_cfgs[mode][index]
        if cfg is old:
            return
        self._check_type(term_name, cfg, EventTermCfg)
        if cfg.mode != mode or cfg.is_global_time != old.is_global_time:
            raise ConfigError(f"{self._owner(term_name)}: mode and is_global_time cannot be changed")
        self._check_event(term_name, cfg)
        self._unbound = [(name, unbound) for name, unbound in self._unbound if unbound is not old]
        self._bind_term(term_name, cfg)
        cfgs = self._mode_term_cfgs[mode]
        cfgs[index] = cfg
        self._put_term_cfg(term_name, cfg)
        self._mode_class_term_cfgs[mode] = [c for c in cfgs if isinstance(c.func, ManagerTermBase)]

    def _find(self, term_name: str) -> tuple[str, int]:
        for mode, names in self._mode_term_names.items():
            if term_name in names:
                return mode, names.index(term_name)
        names = [name for mode_names in self._mode_term_names.values() for name in mode_names]
        raise ConfigError(f"{self._owner(term_name)} not found: {suggest(term_name, names)}")


def _draw_interval(cfg: EventTermCfg, count: int, device: str | torch.device) -> torch.Tensor:
    """Seconds until the next application, for ``count`` timers."""
    assert cfg.interval_range_s is not None  # checked with the term
    lower_s, upper_s = cfg.interval_range_s
    return torch.empty(count, device=device).uniform_(lower_s, upper_s)
