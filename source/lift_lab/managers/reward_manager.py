"""Rewards: the weighted sum of the terms, and each term's share of the episode."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.utils.errors import ConfigError, ConfigTypeError

from ._table import render_table
from ._term_managers import FunctionTermManager
from .manager_base import EnvIds, as_env_id_tensor
from .manager_term_cfg import RewardTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class RewardManager(FunctionTermManager):
    """Sums ``value * weight * dt`` over the terms.

    One buffer of shape (num_terms, num_envs) holds the values of all terms. So the sum and the episode's sums take one
    operation each. Source: Isaac Lab's ``RewardManager``.
    """

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset(
        {"_factor_column", "_factor_row", "_factors", "_shape", "_values_by_env"}
    )

    term_cfg_type = RewardTermCfg

    def __init__(self, cfg: object, env: ManagerBasedRLEnv):
        """Prepare the terms and their buffers.

        Raises:
            TypeError: a weight is not a number.
        """
        super().__init__(cfg, env)
        shape = (len(self._term_names), self.num_envs)
        self._values = torch.zeros(shape, device=self.device)
        self._values_by_env = self._values.t()
        self._sums = torch.zeros(shape, device=self.device)
        self._sums_before = torch.zeros_like(self._sums)  # the last step, kept in case that it has to be left out
        self._log_names = [f"Episode_Reward/{name}" for name in self._term_names]
        self._skipped = torch.zeros(self.num_envs, device=self.device)
        self._shape = self._skipped.shape
        self._factors: list[float] = []
        self._factor_row = torch.zeros(shape[0], device=self.device)
        self._factor_column = self._factor_row.unsqueeze(1)

    def __str__(self) -> str:
        rows = [
            (i, name, float(cfg.weight))
            for i, (name, cfg) in enumerate(zip(self._term_names, self._term_cfgs, strict=True))
        ]
        return (
            f"<RewardManager> contains {len(self._term_names)} active terms.\n"
            f"{render_table('Active Reward Terms', ['Index', 'Name', 'Weight'], rows)}"
        )

    def _accept_term(self, term_name: str, term_cfg: RewardTermCfg) -> None:
        if not isinstance(term_cfg.weight, (int, float)):
            raise ConfigTypeError(f"{self._owner(term_name)}: weight must be a number, not {term_cfg.weight!r}")
        super()._accept_term(term_name, term_cfg)

    def compute(self, dt: float) -> torch.Tensor:
        """Call the terms of non-zero weight and sum them.

        Args:
            dt: The environment step in seconds.

        Returns:
            The reward of the step, a new tensor of shape (num_envs,).

        Raises:
            ValueError: a term returned another shape than (num_envs,).
        """
        if not self._term_cfgs:
            return torch.zeros_like(self._skipped)
        values, factors = [], []
        for name, cfg in zip(self._term_names, self._term_cfgs, strict=True):
            value: Any = cfg.func(self._env, **cfg.params) if cfg.weight != 0.0 else self._skipped
            if not isinstance(value, torch.Tensor):
                value = torch.full_like(self._skipped, value)
            elif value.shape != self._shape:
                raise ConfigError(
                    f"{self._owner(name)} returned shape {tuple(value.shape)}, expected ({self.num_envs},)"
                )
            values.append(value)
            factors.append(cfg.weight * dt)
        torch.stack(values, out=self._values)
        if factors != self._factors:  # weights change with curricula only
            self._factors = factors
            self._factor_row = torch.tensor(factors, device=self.device)
            self._factor_column = self._factor_row.unsqueeze(1)
        torch.addcmul(self._sums, self._values, self._factor_column, out=self._sums_before)
        self._sums, self._sums_before = self._sums_before, self._sums
        return torch.mv(self._values_by_env, self._factor_row)

    def leave_out_last_step(self, envs: torch.Tensor) -> None:
        """Subtract the values that the last :meth:`compute` added to the episodes' sums of some environments.

        Args:
            envs: which ones, a bool tensor of shape (num_envs,).
        """
        self._sums.copy_(torch.where(envs, self._sums_before, self._sums))

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Close the episodes of some environments.

        Returns:
            ``Episode_Reward/{term}``: mean over the environments of the episode's sum of ``value * weight *
            dt``, divided by the configured episode length in seconds. 0-dim tensors.
        """
        ids = as_env_id_tensor(env_ids, self.num_envs, self.device)
        means = self._sums.index_select(1, ids).mean(dim=1) / self._env.max_episode_length_s
        self._sums.index_fill_(1, ids, 0.0)
        self._reset_class_terms(slice(None) if env_ids is None else env_ids)
        return dict(zip(self._log_names, means.unbind(), strict=True))

    def episode_sum(self, term_name: str) -> torch.Tensor:
        """The sum of ``value * weight * dt`` of a term over the episode so far, shape (num_envs,).

        Raises:
            ConfigError: there is no such term.
        """
        self.get_term_cfg(term_name)
        return self._sums[self._term_names.index(term_name)]

    @property
    def term_values(self) -> torch.Tensor:
        """Values of all terms at the last step, not weighted, shape (num_terms, num_envs)."""
        return self._values

    @property
    def term_sums(self) -> torch.Tensor:
        """Sums of ``value * weight * dt`` of each term over the running episodes, shape (num_terms, num_envs)."""
        return self._sums

    @property
    def _episode_sums(self) -> dict[str, torch.Tensor]:
        """Isaac Lab's name for :attr:`term_sums` by term, which task files read."""
        return dict(zip(self._term_names, self._sums, strict=True))

    def get_active_iterable_terms(self, env_idx: int) -> list[tuple[str, list[float]]]:
        values = self._values[:, env_idx].tolist()
        return [
            (name, [value * cfg.weight])
            for name, value, cfg in zip(self._term_names, values, self._term_cfgs, strict=True)
        ]
