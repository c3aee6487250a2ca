"""Commands: goals that each environment holds for a while and then draws anew."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from ._table import render_table
from ._term_managers import DebugVisTerm, ObjectTermManager
from .manager_base import EnvIds, Foretold, as_env_id_tensor
from .manager_term_cfg import CommandTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class CommandTerm(DebugVisTerm, ABC):
    """A command and the timers that decide when it is drawn anew.

    Source: Isaac Lab's ``CommandTerm``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"log_counts"})

    cfg: CommandTermCfg
    """The term's config."""

    metrics: dict[str, torch.Tensor]
    """Values to log at each reset. Shape of each is (num_envs,)."""

    time_left: torch.Tensor
    """Seconds until the command is drawn anew. Shape is (num_envs,)."""

    command_counter: torch.Tensor
    """Commands drawn in the current episode. Shape is (num_envs,)."""

    log_counts: dict[str, int]
    """Episodes behind the means that the last :meth:`reset` returned; those not named are of all that ended."""

    def __init__(self, cfg: CommandTermCfg, env: ManagerBasedRLEnv):
        """Make the timers; every one is due at the first :meth:`compute` or :meth:`reset`."""
        super().__init__(cfg, env)
        self.metrics, self.log_counts = {}, {}
        self.time_left = torch.zeros(self.num_envs, device=self.device)
        self.command_counter = torch.zeros(self.num_envs, device=self.device, dtype=torch.long)
        self._rows: torch.Tensor | None = None  # what _in_rows() made
        self._row_of_metric: dict[str, torch.Tensor] = {}
        self._due_ids: torch.Tensor | None = None
        self._counted_ids: torch.Tensor | None = None

    @property
    @abstractmethod
    def command(self) -> torch.Tensor:
        """The command. Shape is (num_envs, command_dim)."""

    def reset(self, env_ids: EnvIds = None) -> dict[str, torch.Tensor]:
        """Start an episode with a new command.

        Returns:
            Mean of each metric over those of the environments that count, all of which are zeroed then: 0-dim tensors
            by metric name. Empty where none counts.
        """
        ids = as_env_id_tensor(env_ids, self.num_envs, self.device)
        counted, self._counted_ids = self._counted_ids, None
        if counted is None:
            counted = self.counted_ids(ids)
        self.log_counts = {}
        extras = self._episode_means(counted) if self.metrics and len(counted) > 0 else {}
        self.log_counts = dict.fromkeys(extras, len(counted)) | self.log_counts
        if self._rows is not None:
            self._rows.index_fill_(1, ids, 0.0)
        for value in self._loose_metrics():
            value.index_fill_(0, ids, 0.0)
        self.command_counter.index_fill_(0, ids, 0)
        self._resample(ids)
        return extras

    def finish_episodes(self, env_ids: torch.Tensor) -> None:
        """Bring metrics up to the last step of episodes that end, before anything of them is reset.

        Isaac Lab updates metrics after resets, and so does :meth:`compute`: without this, what a metric says of an
        episode leaves out its last step.

        Args:
            env_ids: environments whose episode ends, a LongTensor.
        """

    @property
    def counts(self) -> torch.Tensor | None:
        """Whether each environment's present episode counts in means over episodes, a bool tensor of shape (num_envs,).

        None where all count, which is so unless a term says otherwise.
        """
        return None

    def counted_ids(self, env_ids: torch.Tensor) -> torch.Tensor:
        """Those of some environments whose present episode counts; on a GPU the host waits, unless all do.

        Args:
            env_ids: a LongTensor.
        """
        counts = self.counts
        return env_ids if counts is None else env_ids[counts[env_ids]]

    def _episode_means(self, env_ids: torch.Tensor) -> dict[str, torch.Tensor]:
        """Mean of each metric over some environments, at least one, whose episode ends: 0-dim tensors.

        Of a mean over fewer of them :attr:`log_counts` is told.
        """
        rows = torch.stack(list(self.metrics.values())) if self._loose_metrics() else self._rows
        means = rows.index_select(1, env_ids).mean(dim=1)  # type: ignore[union-attr]
        return dict(zip(self.metrics, means.unbind(), strict=False))

    def _in_rows(self, metrics: Sequence[str], more: int = 0) -> torch.Tensor:
        """Make all metrics zeroed rows of one tensor, so that a reset zeroes them and takes their means at once.

        They have to be written in place then. One that is replaced, or added later, costs operations of its own.

        Args:
            metrics: names of all metrics.
            more: how many rows that are no metrics follow.

        Returns:
            The rows, shape (len(metrics) + more, num_envs).
        """
        self._rows = torch.zeros(len(metrics) + more, self.num_envs, device=self.device)
        self._row_of_metric = dict(zip(metrics, self._rows, strict=False))
        self.metrics.update(self._row_of_metric)
        return self._rows

    def _loose_metrics(self) -> list[torch.Tensor]:
        """Metrics that are no rows of :attr:`_rows`."""
        return [value for name, value in self.metrics.items() if self._row_of_metric.get(name) is not value]

    def compute(self, dt: float) -> None:
        """Update metrics, then timers, then draw the commands that are due, then update the commands.

        Args:
            dt: Seconds since the last call.
        """
        self._update_metrics()
        self.time_left -= dt
        due, self._due_ids = self._due_ids, None
        self._counted_ids = None
        if due is None:
            due = (self.time_left <= 0.0).nonzero().flatten()
        if len(due) > 0:
            self._resample(due)
        self._update_command()

    def foretell(self, dt: float, ended: torch.Tensor) -> list[Foretold]:
        """Which commands the next :meth:`compute` will draw, and which episodes that end count in means over episodes.

        So that the host can ask for this and for the ended episodes at once. A timer that the term itself changes in
        between, other than by a reset, then counts one step later.

        Args:
            dt: Seconds that will be given to :meth:`compute`.
            ended: Environments that will be reset before it, shape (num_envs,).

        Returns:
            Masks, and who is told where they are true. Nothing of what cannot be told, as of timers that may be due
            right after a reset.
        """
        if type(self).compute is not CommandTerm.compute:
            return []
        foretold = self._foretell_counted(ended)
        if type(self)._resample is CommandTerm._resample and self.cfg.resampling_time_range[0] > dt:
            foretold.append(((self.time_left <= dt) & ~ended, self._take_due_ids))
        return foretold

    def _foretell_counted(self, ended: torch.Tensor) -> list[Foretold]:
        """What the coming :meth:`reset` would have to ask for."""
        counts = self.counts
        return [] if counts is None else [(ended & counts, self._take_counted_ids)]

    def _take_due_ids(self, env_ids: torch.Tensor) -> None:
        self._due_ids = env_ids

    def _take_counted_ids(self, env_ids: torch.Tensor) -> None:
        self._counted_ids = env_ids

    def _resample(self, env_ids: torch.Tensor) -> None:
        """Draw timer and command of some environments."""
        if len(env_ids) > 0:
            drawn_s = torch.empty(len(env_ids), device=self.device).uniform_(*self.cfg.resampling_time_range)
            self.time_left[env_ids] = drawn_s
            self._resample_command(env_ids)
            self.command_counter.index_add_(0, env_ids, torch.ones_like(env_ids))

    @abstractmethod
    def _update_metrics(self) -> None:
        """Write :attr:`metrics` from the current state."""

    @abstractmethod
    def _resample_command(self, env_ids: torch.Tensor) -> None:
        """Draw the command of some environments, given as a LongTensor."""

    @abstractmethod
    def _update_command(self) -> None:
        """Update the command where it depends on the current state."""


class CommandManager(ObjectTermManager):
    """Holds the command terms.

    Source: Isaac Lab's ``CommandManager``.
    """

    term_cfg_type = CommandTermCfg
    term_type = CommandTerm

    def __str__(self) -> str:
        rows = [(i, name, type(term).__name__) for i, (name, term) in enumerate(self._terms.items())]
        return (
            f"<CommandManager> contains {len(self._terms)} active terms.\n"
            f"{render_table('Active Command Terms', ['Index', 'Name', 'Type'], rows)}"
        )

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Reset the terms; logs ``Metrics/{term}/{metric}``."""
        extras = {}
        for name, term in self._terms.items():
            for metric, value in term.reset(env_ids=env_ids).items():
                extras[f"Metrics/{name}/{metric}"] = value
        return extras

    @property
    def log_counts(self) -> dict[str, int]:
        """Episodes behind entries of the last :meth:`reset`'s log; those not named are of all episodes that ended."""
        terms = self._terms.items()
        return {f"Metrics/{name}/{key}": count for name, term in terms for key, count in term.log_counts.items()}

    def finish_episodes(self, env_ids: torch.Tensor) -> None:
        """Tell every term which episodes end; see :meth:`CommandTerm.finish_episodes`."""
        for term in self._terms.values():
            term.finish_episodes(env_ids)

    def foretell(self, dt: float, ended: torch.Tensor) -> list[Foretold]:
        """What every term can tell of the next :meth:`compute`; see :meth:`CommandTerm.foretell`."""
        return [entry for term in self._terms.values() for entry in term.foretell(dt, ended)]

    def compute(self, dt: float) -> None:
        """Update every term; ``dt`` is the environment step in seconds."""
        for term in self._terms.values():
            term.compute(dt)

    def get_command(self, name: str) -> torch.Tensor:
        """The command of the term of this name. Shape is (num_envs, command_dim).

        Raises:
            NotFoundError: no term has this name.
        """
        return self.get_term(name).command

    def get_active_iterable_terms(self, env_idx: int) -> list[tuple[str, list[float]]]:
        return [(name, term.command[env_idx].tolist()) for name, term in self._terms.items()]
