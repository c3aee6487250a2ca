"""Metrics: one number of each episode a term, which nothing learns from, for the log."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.utils.errors import ConfigError, suggest

from ._table import render_table
from ._term_managers import FunctionTermManager
from .manager_base import EnvIds, as_env_id_tensor
from .manager_term_cfg import MetricsTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv

_LOG_NAME = re.compile(r"[\w.-]+(/[\w.-]+)*")


def _mean(episode: torch.Tensor, values: torch.Tensor, steps: torch.Tensor) -> None:
    episode.lerp_(values, steps.reciprocal())


def _sum(episode: torch.Tensor, values: torch.Tensor, steps: torch.Tensor) -> None:
    episode.add_(values)


def _last(episode: torch.Tensor, values: torch.Tensor, steps: torch.Tensor) -> None:
    episode.copy_(values)


def _max(episode: torch.Tensor, values: torch.Tensor, steps: torch.Tensor) -> None:
    torch.where(steps == 1, values, torch.maximum(episode, values), out=episode)


def _first(episode: torch.Tensor, values: torch.Tensor, steps: torch.Tensor) -> None:
    torch.where(episode.isnan(), values, episode, out=episode)


REDUCTIONS: dict[str, Callable[[torch.Tensor, torch.Tensor, torch.Tensor], None]] = {
    "last": _last,
    "max": _max,
    "mean": _mean,
    "sum": _sum,
    "first": _first,
}
"""Reductions of the values of an episode's steps to one. Each updates the episode's value so far by the step's value,
both of shape (num_terms, num_envs). The last argument is the number of steps with this one, shape (num_envs,)."""


class MetricsManager(FunctionTermManager):
    """Measures every step, before episodes end, and logs the means over the episodes that ended.

    Commands add terms to those of the config (:meth:`~lift_lab.managers.CommandTerm.metrics_terms`), unless a term of
    the config has the same log name. A step in which the physics of an environment failed does not count for its
    episode. mjlab has a manager of this name.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"log_counts", "_groups"})

    term_cfg_type = MetricsTermCfg

    log_counts: dict[str, int]
    """Number of episodes behind each entry that the last :meth:`reset` returned."""

    def __init__(self, cfg: object, env: ManagerBasedRLEnv):
        """Prepare the terms and their buffers.

        Raises:
            ConfigError: an unknown ``reduce``, a ``log_as`` that is no name, or two metrics of one name.
        """
        self._log_names: list[str] = []
        super().__init__(cfg, env)
        kinds = [term.reduce for term in self._term_cfgs]
        starts = {kind: kinds.index(kind) for kind in REDUCTIONS if kind in kinds}
        self._groups = [(REDUCTIONS[kind], slice(start, start + kinds.count(kind))) for kind, start in starts.items()]
        self._num_plain = len(kinds) - kinds.count("first")
        self._values = torch.zeros(len(kinds), self.num_envs, device=self.device)
        self._episode = torch.zeros_like(self._values)
        self._episode[self._num_plain :] = torch.nan
        self._steps = torch.zeros(self.num_envs, device=self.device)
        self._left_out = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)
        self._has_measured = False
        self.log_counts = {}

    def __str__(self) -> str:
        terms = zip(self._term_names, self._term_cfgs, self._log_names, strict=True)
        rows = [(i, name, cfg.reduce, log_name) for i, (name, cfg, log_name) in enumerate(terms)]
        return (
            f"<MetricsManager> contains {len(rows)} active terms.\n"
            f"{render_table('Active Metrics Terms', ['Index', 'Name', 'Reduce', 'Logged as'], rows)}"
        )

    def _term_items(self, term_type: type, cfg: Any, settings: Sequence[str] = ()) -> Iterator[tuple[str, Any]]:
        """The commands' terms and those of the config; terms of one reduction stand together, "first" at the end."""
        own = dict(super()._term_items(term_type, cfg, settings))
        taken = {term.log_as or name for name, term in own.items()}
        terms, commands = {}, self._env.command_manager
        for command, term in ((name, commands.get_term(name)) for name in commands.active_terms):
            taken |= {f"{command}/{metric}" for metric in term.metrics}
            terms |= {f"{command}/{metric}": term_cfg for metric, term_cfg in term.metrics_terms(command).items()}
        terms = {name: term_cfg for name, term_cfg in terms.items() if name not in taken} | own
        for name, term_cfg in terms.items():
            if term_cfg.reduce not in REDUCTIONS:
                hint = suggest(str(term_cfg.reduce), REDUCTIONS)
                raise ConfigError(f"{self._owner(name)}: unknown reduce {term_cfg.reduce!r}: {hint}")
        ranks = list(REDUCTIONS)
        yield from sorted(terms.items(), key=lambda item: ranks.index(item[1].reduce))

    def _accept_term(self, term_name: str, term_cfg: MetricsTermCfg) -> None:
        owner, log_as = self._owner(term_name), term_name if term_cfg.log_as is None else term_cfg.log_as
        if not isinstance(log_as, str) or not _LOG_NAME.fullmatch(log_as):
            raise ConfigError(f"{owner}: log_as must be a name such as 'goal/error', not {log_as!r}")
        if log_as.startswith("Metrics/"):
            raise ConfigError(f"{owner}: log_as must not begin with 'Metrics/', which is put before it: {log_as!r}")
        if log_as.startswith("physics/"):
            raise ConfigError(f"{owner}: 'Metrics/physics/' is for failures of the physics; use another log_as")
        command, _, metric = log_as.partition("/")
        commands, log_name = self._env.command_manager, f"Metrics/{log_as}"
        if command in commands.active_terms and metric in commands.get_term(command).metrics:
            raise ConfigError(f"{owner}: the command '{command}' itself logs '{log_name}'; use another log_as")
        if log_name in self._log_names:
            other = self._term_names[self._log_names.index(log_name)]
            raise ConfigError(f"{owner} and term '{other}' are both logged as '{log_name}'; use another log_as")
        super()._accept_term(term_name, term_cfg)
        self._log_names.append(log_name)

    def set_term_cfg(self, term_name: str, cfg: Any) -> None:
        """Replace a term's config by another of the same ``reduce`` and ``log_as``, resolving it if it is a new one.

        Raises:
            ConfigError: no term has this name, or the config cannot be resolved.
            TypeError: the config is of another manager.
        """
        old = self.get_term_cfg(term_name)
        self._check_type(term_name, cfg, MetricsTermCfg)
        if (cfg.reduce, cfg.log_as) != (old.reduce, old.log_as):
            raise ConfigError(f"{self._owner(term_name)}: reduce and log_as cannot be changed")
        if cfg is not old:
            self._resolve_common_term_cfg(term_name, cfg, self.min_argc)
            self._term_cfgs[self._index(term_name)] = cfg
            self._list_class_terms()

    @property
    def log_names(self) -> list[str]:
        """Names in the log, ``Metrics/...``, in the order of the terms."""
        return list(self._log_names)

    def compute(self) -> None:
        """Call every term once and take its value into the episode's.

        Raises:
            ConfigError: a term returned no tensor of shape (num_envs,).
        """
        if not self._term_cfgs:
            return
        values = []
        for name, cfg in zip(self._term_names, self._term_cfgs, strict=True):
            value: Any = cfg.func(self._env, **cfg.params)
            if not isinstance(value, torch.Tensor) or value.shape != self._steps.shape:
                found = f"shape {tuple(value.shape)}" if isinstance(value, torch.Tensor) else repr(value)
                expected = f"a tensor of shape ({self.num_envs},)"
                raise ConfigError(f"{self._owner(name)} returned {found}, expected {expected}")
            values.append(value)
        torch.stack(values, out=self._values)
        self._has_measured = True
        self._steps += 1.0
        failed = self._env.physics_failed
        episode = self._episode if failed is None else self._episode.clone()
        for reduction, rows in self._groups:
            reduction(episode[rows], self._values[rows], self._steps)
        if failed is not None:
            torch.where(failed, self._episode, episode, out=self._episode)

    def episode_value(self, term_name: str) -> torch.Tensor:
        """A metric of the episode so far, shape (num_envs,); NaN where a "first" has not come.

        Raises:
            ConfigError: there is no such term.
        """
        return self._episode[self._index(term_name)]

    def leave_out(self, env_ids: torch.Tensor, left_out: torch.Tensor) -> None:
        """Say of the present episodes of some environments whether the means leave them out.

        Args:
            env_ids: a LongTensor.
            left_out: a bool tensor of shape (len(env_ids),).
        """
        self._left_out[env_ids] = left_out

    def counted_ids(self, env_ids: EnvIds) -> torch.Tensor:
        """Those of some environments whose present episode counts in the means; on a GPU the host waits."""
        ids = as_env_id_tensor(env_ids, self.num_envs, self.device)
        return ids[~self._left_out[ids]]

    def masks(self, dt: float, ended: torch.Tensor) -> dict[Any, torch.Tensor]:
        """Mask of the episodes that the next :meth:`reset` counts."""
        if not self._term_cfgs:
            return {}
        counted = ended & ~self._left_out
        came = ~self._episode[self._num_plain :].isnan() & counted
        firsts = zip(self._log_names[self._num_plain :], came.unbind(), strict=True)
        return {"Metrics/": counted, **dict(firsts)}

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Close the episodes of some environments.

        Returns:
            ``Metrics/{log_as}``: mean over the episodes that count, 0-dim tensors. Of a "first", over those in which
            it came. A mean over no episode is absent, and all are before the first :meth:`compute`.
        """
        ids = as_env_id_tensor(env_ids, self.num_envs, self.device)
        known, firsts = self._env.prefetched, slice(self._num_plain, None)
        counted = known["Metrics/"] if "Metrics/" in known else self.counted_ids(ids)
        means: dict[str, Any] = {}
        self.log_counts = {}
        if self._has_measured and len(counted) > 0:
            rows = self._episode[: self._num_plain].index_select(1, counted).mean(dim=1)
            means = dict(zip(self._log_names, rows.unbind(), strict=False))
            self.log_counts = dict.fromkeys(means, len(counted))
            for name, row in zip(self._log_names[firsts], self._episode[firsts], strict=True):
                came = known[name] if name in known else counted[~row[counted].isnan()]
                if len(came) > 0:
                    means[name], self.log_counts[name] = row[came].mean(), len(came)
        self._episode[: self._num_plain].index_fill_(1, ids, 0.0)
        self._episode[firsts].index_fill_(1, ids, torch.nan)
        self._steps.index_fill_(0, ids, 0.0)
        self._left_out.index_fill_(0, ids, False)
        self._reset_class_terms(slice(None) if env_ids is None else env_ids)
        return means

    def get_active_iterable_terms(self, env_idx: int) -> list[tuple[str, list[float]]]:
        """Log name without ``Metrics/`` and value in the episode so far of every term, for a viewer."""
        names = [name.removeprefix("Metrics/") for name in self._log_names]
        return [(name, [value]) for name, value in zip(names, self._episode[:, env_idx].tolist(), strict=True)]
