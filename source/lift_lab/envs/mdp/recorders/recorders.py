"""Recorder terms. Each returns the name of its data and the data, one row per environment."""

from __future__ import annotations

from typing import Any

import torch

from lift_lab.managers import RecorderTerm
from lift_lab.utils.indexing import EnvIds

__all__ = [
    "InitialStateRecorder",
    "PostStepProcessedActionsRecorder",
    "PostStepStatesRecorder",
    "PreStepActionsRecorder",
    "PreStepFlatPolicyObservationsRecorder",
]


class InitialStateRecorder(RecorderTerm):
    """State of the scene after a reset, relative to the environments' origins."""

    def record_post_reset(self, env_ids: EnvIds) -> tuple[str, Any]:
        """Record ``initial_state``."""
        rows = slice(None) if env_ids is None else env_ids

        def pick(value: Any) -> Any:
            return {k: pick(v) for k, v in value.items()} if isinstance(value, dict) else value[rows]

        return "initial_state", pick(self._env.scene.get_state(is_relative=True))


class PostStepStatesRecorder(RecorderTerm):
    """State of the scene after each step and before resets, relative to the environments' origins."""

    def record_post_step(self) -> tuple[str, Any]:
        """Record ``states``."""
        return "states", self._env.scene.get_state(is_relative=True)


class PreStepActionsRecorder(RecorderTerm):
    """The raw action of each step."""

    def record_pre_step(self) -> tuple[str, torch.Tensor]:
        """Record ``actions``."""
        return "actions", self._env.action_manager.action


class PreStepFlatPolicyObservationsRecorder(RecorderTerm):
    """The observation of the ``policy`` group that each action answers."""

    def record_pre_step(self) -> tuple[str, Any]:
        """Record ``obs``."""
        return "obs", self._env.obs_buf["policy"]


class PostStepProcessedActionsRecorder(RecorderTerm):
    """The processed actions of all terms, side by side."""

    def record_post_step(self) -> tuple[str, torch.Tensor]:
        """Record ``processed_actions``."""
        manager = self._env.action_manager
        parts = [manager.get_term(name).processed_actions for name in manager.active_terms]
        return "processed_actions", torch.cat(parts, dim=-1)
