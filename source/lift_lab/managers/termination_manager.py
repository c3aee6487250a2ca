"""Terminations: which episodes end, and whether they were cut short or reached a terminal state."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.utils.errors import ConfigError, ConfigTypeError

from ._table import render_table
from ._term_managers import FunctionTermManager
from .manager_base import EnvIds
from .manager_term_cfg import TerminationTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class TerminationManager(FunctionTermManager):
    """Combines the terms into *time outs* (the episode was cut short) and *terminated* (a terminal state).

    Every :meth:`compute` returns new tensors; none is overwritten later. Source: Isaac Lab's
    ``TerminationManager``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_none"})

    term_cfg_type = TerminationTermCfg

    def __init__(self, cfg: object, env: ManagerBasedRLEnv):
        """Prepare the terms and their buffers."""
        super().__init__(cfg, env)
        self._none = torch.zeros(self.num_envs, dtype=torch.bool, device=self.device)
        # a row for each term
        self._fired = torch.zeros(len(self._term_names), self.num_envs, dtype=torch.bool, device=self.device)
        self._ended_last_episode = self._fired.clone()
        self._log_names = [f"Episode_Termination/{name}" for name in self._term_names]
        self._dones = self._truncated = self._terminated = self._none

    def __str__(self) -> str:
        rows = [
            (i, name, cfg.time_out) for i, (name, cfg) in enumerate(zip(self._term_names, self._term_cfgs, strict=True))
        ]
        return (
            f"<TerminationManager> contains {len(self._term_names)} active terms.\n"
            f"{render_table('Active Termination Terms', ['Index', 'Name', 'Time Out'], rows)}"
        )

    @property
    def dones(self) -> torch.Tensor:
        """Whether the episode ended. Shape is (num_envs,)."""
        return self._dones

    @property
    def time_outs(self) -> torch.Tensor:
        """Mask of episodes that ended by a time-out, so the value of the last state still counts. Shape is
        (num_envs,)."""
        return self._truncated

    @property
    def terminated(self) -> torch.Tensor:
        """Whether it reached a terminal state. Shape is (num_envs,)."""
        return self._terminated

    def compute(self) -> torch.Tensor:
        """Call the terms.

        Returns:
            Whether each episode ended. Shape is (num_envs,).

        Raises:
            ValueError: a term returned another shape than (num_envs,).
            TypeError: a term returned no booleans.
        """
        if not self._term_cfgs:
            return self._dones
        values = []
        for name, cfg in zip(self._term_names, self._term_cfgs, strict=True):
            value: torch.Tensor = cfg.func(self._env, **cfg.params)
            if value.shape != self._none.shape:
                raise ConfigError(
                    f"{self._owner(name)} returned shape {tuple(value.shape)}, expected ({self.num_envs},)"
                )
            if value.dtype != torch.bool:
                raise ConfigTypeError(f"{self._owner(name)} returned {value.dtype}, expected torch.bool")
            values.append(value)
        self._fired = torch.stack(values)
        rows = self._fired.unbind()
        self._truncated = self._any(rows, time_out=True)
        self._terminated = self._any(rows, time_out=False)
        self._dones = self._truncated | self._terminated
        self._ended_last_episode = torch.where(self._dones, self._fired, self._ended_last_episode)
        return self._dones

    def _any(self, fired: Sequence[torch.Tensor], time_out: bool) -> torch.Tensor:
        """Union of what one kind of terms returned."""
        chosen = [row for row, cfg in zip(fired, self._term_cfgs, strict=True) if bool(cfg.time_out) == time_out]
        if not chosen:
            return torch.zeros_like(self._none)
        union = chosen[0]
        for row in chosen[1:]:
            union = union | row
        return union

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Reset class terms.

        Returns:
            ``Episode_Termination/{term}``: fraction of all environments whose last episode the term ended.
            0-dim tensors.
        """
        fractions = self._ended_last_episode.float().mean(dim=1)
        self._reset_class_terms(slice(None) if env_ids is None else env_ids)
        return dict(zip(self._log_names, fractions.unbind(), strict=True))

    def get_term(self, name: str) -> torch.Tensor:
        """Return the last value of a term. Shape is (num_envs,).

        Raises:
            ConfigError: no term has this name.
        """
        return self._fired[self._index(name)]

    def get_active_iterable_terms(self, env_idx: int) -> list[tuple[str, list[float]]]:
        row = self._fired[:, env_idx].tolist()
        return [(name, [float(done)]) for name, done in zip(self._term_names, row, strict=True)]
