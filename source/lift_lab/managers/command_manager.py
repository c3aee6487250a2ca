"""Commands: goals of each environment that are drawn again at intervals."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Any

import torch

from ._table import render_table
from ._term_managers import DebugVisTerm, ObjectTermManager
from .manager_base import EnvIds, as_env_id_tensor
from .manager_term_cfg import CommandTermCfg, MetricsTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class CommandTerm(DebugVisTerm, ABC):
    """Base class of command terms: a command and the timers that decide when it is drawn again.

    Source: Isaac Lab's ``CommandTerm``.
    """

    cfg: Any
    """The term's config."""

    metrics: dict[str, torch.Tensor]
    """Isaac Lab's way to measure, for a class of your own: what :meth:`_update_metrics` writes, to log at each reset.
    Shape of each is (num_envs,). A metrics term measures the last step of an episode, too."""

    time_left: torch.Tensor
    """Seconds until the command is drawn again. Shape is (num_envs,)."""

    command_counter: torch.Tensor
    """Commands drawn in the current episode. Shape is (num_envs,)."""

    def __init__(self, cfg: CommandTermCfg, env: ManagerBasedRLEnv):
        """Make the timers; every one is due at the first :meth:`compute` or :meth:`reset`."""
        super().__init__(cfg, env)
        self.metrics = {}
        self.time_left = torch.zeros(self.num_envs, device=self.device)
        self.command_counter = torch.zeros(self.num_envs, device=self.device, dtype=torch.long)

    @property
    @abstractmethod
    def command(self) -> torch.Tensor:
        """The command. Shape is (num_envs, command_dim)."""

    def reset(self, env_ids: EnvIds = None) -> dict[str, torch.Tensor]:
        """Start an episode with a new command.

        Returns:
            Mean of each of the :attr:`metrics` over these environments, all of which are zeroed then: 0-dim tensors by
            metric name. Empty without an environment.
        """
        ids = as_env_id_tensor(env_ids, self.num_envs, self.device)
        extras = {name: value[ids].float().mean() for name, value in self.metrics.items()} if len(ids) > 0 else {}
        for value in self.metrics.values():
            value.index_fill_(0, ids, 0.0)
        self.command_counter.index_fill_(0, ids, 0)
        self._resample(ids)
        return extras

    def metrics_terms(self, command_name: str) -> dict[str, MetricsTermCfg]:
        """Metrics terms that come with the command; ``Metrics/{command}/{name}`` in the log.

        Args:
            command_name: Name of this command in the config.
        """
        return {}

    def compute(self, dt: float) -> None:
        """Update metrics, then timers, then draw the commands that are due, then update the commands.

        Args:
            dt: Seconds since the last call.
        """
        self._update_metrics()
        self.time_left -= dt
        due = self._env.prefetched.pop(self, None)
        if due is None:
            due = (self.time_left <= 0.0).nonzero().flatten()
        if len(due) > 0:
            self._resample(due)
        self._update_command()

    def due_mask(self, dt: float, ended: torch.Tensor) -> torch.Tensor | None:
        """Predict which commands the next :meth:`compute` will draw.

        Args:
            dt: Seconds that will be given to :meth:`compute`.
            ended: Environments that will be reset before it, shape (num_envs,).

        Returns:
            Bool tensor of shape (num_envs,). None where that cannot be predicted: a reset may draw less than ``dt``, or
            your own class changes how the timers run.
        """
        own = type(self)
        if own.compute is not CommandTerm.compute or own._resample is not CommandTerm._resample:
            return None
        return (self.time_left <= dt) & ~ended if self.cfg.resampling_time_range[0] > dt else None

    def resample(self, env_ids: torch.Tensor) -> None:
        """Draw the commands of some environments now, given as a LongTensor, and update all of them."""
        self._resample(env_ids)
        self._update_command()

    def _resample(self, env_ids: torch.Tensor) -> None:
        """Draw timer and command of some environments."""
        if len(env_ids) > 0:
            drawn_s = torch.empty(len(env_ids), device=self.device).uniform_(*self.cfg.resampling_time_range)
            self.time_left[env_ids] = drawn_s
            self._resample_command(env_ids)
            self.command_counter.index_add_(0, env_ids, torch.ones_like(env_ids))

    def _update_metrics(self) -> None:
        """Write :attr:`metrics` from the current state, which after a reset is that of the new episode."""

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

    def masks(self, dt: float, ended: torch.Tensor) -> dict[Any, torch.Tensor]:
        """Predict which commands the next :meth:`compute` will draw, by term."""
        masks = {term: term.due_mask(dt, ended) for term in self._terms.values()}
        return {term: mask for term, mask in masks.items() if mask is not None}

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
