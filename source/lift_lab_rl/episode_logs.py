"""The environment's log entries of several steps, each averaged over the episodes behind it."""

from __future__ import annotations

from typing import Any

import torch

FAILURES = "Metrics/physics/"
"""Entries that count environments whose physics failed: they are added up, not averaged."""


class EpisodeLogs:
    """Collects ``extras["log"]`` step by step, for curves of the same meaning with every learning library."""

    def __init__(self) -> None:
        self._entries: list[tuple[dict[str, Any], torch.Tensor, dict[str, int]]] = []
        self._last: dict[str, Any] | None = None

    def clear(self) -> None:
        """Begin with no entries."""
        self._entries.clear()

    def add(self, extras: dict[str, Any], dones: torch.Tensor) -> None:
        """Add one environment step.

        Args:
            extras: the step's, with the environment's ``log``, and in ``log_counts`` how many episodes an entry is the
                mean of, if not of all that ended.
            dones: which episodes ended, a bool tensor of shape (num_envs,). It is read in :meth:`means`.
        """
        log = extras.get("log")
        # An environment keeps its last log until the next reset: each is counted once.
        if log and log is not self._last:
            self._entries.append((dict(log), dones, extras.get("log_counts", {})))
            self._last = log

    def entries(self) -> list[dict[str, Any]]:
        """The logs one by one."""
        return [log for log, *_ in self._entries]

    def means(self) -> dict[str, float]:
        """Each entry averaged over its episodes that ended; failures of the physics are added up.

        Logs of a step in which no episode ended, as of the first reset, are left out.
        """
        if not self._entries:
            return {}
        ended: list[int] = torch.stack([dones for _, dones, _ in self._entries]).sum(1).tolist()
        logs = [(log, n, counts) for (log, _, counts), n in zip(self._entries, ended, strict=True) if n]
        found = {}
        for key in dict.fromkeys(key for log, *_ in logs for key in log):
            pairs = [(log[key], counts.get(key, everyone)) for log, everyone, counts in logs if key in log]
            values = [float(v.float().mean()) if isinstance(v, torch.Tensor) else float(v) for v, _ in pairs]
            weights = [weight for _, weight in pairs]
            if key.startswith(FAILURES):
                found[key] = sum(values)
            else:
                found[key] = sum(v * w for v, w in zip(values, weights, strict=True)) / sum(weights)
        return found
