"""Advantage clipping: rare large losses do not drown the rest of a rollout."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch

from lift_lab.utils.errors import ConfigError
from lift_lab_rl import distributed


@dataclass(frozen=True)
class AdvantageClip:
    """Clips normalised advantages and normalises them again."""

    limit: float | None = None
    """Largest size of an advantage in standard deviations; None clips nothing."""
    start: int = 0
    """First iteration that clips."""

    def __post_init__(self) -> None:
        if self.limit is not None and not 0.0 < self.limit < math.inf:
            raise ConfigError(f"agent.algorithm.advantage_clip is {self.limit}; it must be above 0, or null")

    def __call__(self, advantages: torch.Tensor, iteration: int) -> torch.Tensor:
        """Clip the advantages of a rollout.

        Args:
            advantages: normalised advantages, shape (steps, num_envs, 1).
            iteration: iterations finished before this one, counted from where schedules begin; -1 before that.

        Returns:
            Shape (steps, num_envs, 1); the same tensor where nothing is clipped.
        """
        if self.limit is None or iteration < self.start:
            return advantages
        return distributed.standardise(advantages.clamp(-self.limit, self.limit))
