"""Success rate of a watched policy."""

from __future__ import annotations

from collections import deque
from typing import Any

import torch

from lift_lab_rl.evaluation import PROBE


class SuccessCounter:
    """Success of the running episodes, and of the last hundred that ended."""

    def __init__(self, env: Any):
        """Find the probe.

        Args:
            env: environment; without :func:`~lift_lab_rl.evaluation.add_success_probe` nothing is counted.
        """
        manager = env.termination_manager
        self._probe: Any = manager.get_term_cfg(PROBE).func if PROBE in manager.active_terms else None
        self._ended: deque[bool] = deque(maxlen=100)

    @property
    def is_known(self) -> bool:
        """Whether the task says what success is."""
        return self._probe is not None

    def note(self, dones: torch.Tensor) -> None:
        """Count the episodes that just ended, shape (num_envs,)."""
        if self._probe is None:
            return
        ids = dones.nonzero().flatten()
        if len(ids):
            self._ended.extend((self._probe.first_step[ids] > 0).tolist())
            self._probe.first_step[ids] = 0

    def forget(self) -> None:
        """Start again, e.g. with another checkpoint."""
        self._ended.clear()
        if self._probe is not None:
            self._probe.first_step[:] = 0

    def has_succeeded(self, env_id: int) -> bool:
        """Whether an environment's running episode succeeded already."""
        return self._probe is not None and bool(self._probe.first_step[env_id] > 0)

    @property
    def episodes(self) -> int:
        """Episodes counted, at most a hundred."""
        return len(self._ended)

    @property
    def rate(self) -> float | None:
        """Share of them that succeeded; None before the first."""
        return sum(self._ended) / len(self._ended) if self._ended else None
