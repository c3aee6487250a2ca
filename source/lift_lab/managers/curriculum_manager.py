"""Curricula: changes of the task that are decided whenever environments reset."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import torch

from ._table import render_table
from ._term_managers import FunctionTermManager
from .manager_base import EnvIds, ManagerTermBase, named_reward
from .manager_term_cfg import CurriculumTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class CurriculumManager(FunctionTermManager):
    """Calls the curriculum terms with the environments that will be reset, and logs the results.

    Source: Isaac Lab's ``CurriculumManager``.
    """

    term_cfg_type = CurriculumTermCfg
    min_argc = 2

    def __init__(self, cfg: object, env: ManagerBasedRLEnv):
        """Prepare the terms; nothing is logged before the first :meth:`compute`."""
        super().__init__(cfg, env)
        self._curriculum_state: dict[str, Any] = dict.fromkeys(self._term_names)

    def __str__(self) -> str:
        return (
            f"<CurriculumManager> contains {len(self._term_names)} active terms.\n"
            f"{render_table('Active Curriculum Terms', ['Index', 'Name'], list(enumerate(self._term_names)))}"
        )

    def may_change_weight(self, reward: str) -> bool:
        """Whether a term changes the weight of a reward term.

        A function declares it by its param ``term_name``, a class by
        :meth:`~lift_lab.managers.ManagerTermBase.scheduled_rewards`. One that says nothing may change any.
        """
        for cfg in self._term_cfgs:
            names = cfg.func.scheduled_rewards() if isinstance(cfg.func, ManagerTermBase) else named_reward(cfg)
            if names is None or reward in names:
                return True
        return False

    def compute(self, env_ids: EnvIds = None) -> None:
        """Call every term with the environments about to reset."""
        ids = slice(None) if env_ids is None else env_ids
        for name, cfg in zip(self._term_names, self._term_cfgs, strict=True):
            self._curriculum_state[name] = cfg.func(self._env, ids, **cfg.params)

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Reset class terms; logs the last state of each term as ``Curriculum/{term}``, of a dict as
        ``Curriculum/{term}/{key}``, and nothing of None. ``env_ids`` only reaches the class terms."""
        extras = {}
        for name, state in self._curriculum_state.items():
            for key, value in _flatten(f"Curriculum/{name}", state):
                extras[key] = value.detach().clone() if isinstance(value, torch.Tensor) else value
        self._reset_class_terms(slice(None) if env_ids is None else env_ids)
        return extras

    def get_active_iterable_terms(self, env_idx: int) -> list[tuple[str, list[float]]]:
        terms = []
        for name, state in self._curriculum_state.items():
            values = [float(value) for _, value in _flatten(name, state)]
            if values:
                terms.append((name, values))
        return terms


def _flatten(name: str, state: Any) -> list[tuple[str, Any]]:
    """A term's state as log entries, without None."""
    entries = {f"{name}/{key}": value for key, value in state.items()} if isinstance(state, dict) else {name: state}
    return [(key, value) for key, value in entries.items() if value is not None]
