"""Schedules that start when a metric reaches a level, instead of at a step of the training."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.indexing import EnvIds
from lift_lab.utils.saved_state import Stateful

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv
    from lift_lab.managers import ManagerTermBase


class MetricLevel(Stateful):
    """Environment steps since a metric first reached a level.

    The metric is a running mean over the last episodes that ended, as many as there are environments. It starts at
    zero. Episodes that the metrics leave out do not count, nor do those in which the metric is NaN.
    """

    def __init__(self, metric: str, level: float):
        """Start before the level.

        Args:
            metric: name of a metrics term.
            level: mean that has to be reached.
        """
        self._metric, self._level = metric, level
        self._mean, self._reached_at = 0.0, -1

    def elapsed(self, env: ManagerBasedRLEnv, env_ids: EnvIds) -> int:
        """Count the episodes that end now; call once in each reset. On a GPU the host waits until the level is reached.

        Args:
            env: the environment.
            env_ids: environments that will be reset.

        Returns:
            Environment steps since the level was reached; -1 before.
        """
        if self._reached_at < 0 < env.common_step_counter:  # at step 0 no episode has ended
            metrics = env.metrics_manager
            ended = metrics.episode_value(self._metric)[metrics.counted_ids(env_ids)]
            ended = ended[~ended.isnan()]
            if len(ended) > 0:
                self._mean += (float(ended.mean()) - self._mean) * min(1.0, len(ended) / env.num_envs)
                if self._mean >= self._level:
                    self._reached_at = env.common_step_counter
        return -1 if self._reached_at < 0 else env.common_step_counter - self._reached_at


def metric_level(term: ManagerTermBase, env: ManagerBasedRLEnv) -> MetricLevel | None:
    """Return what a curriculum term's parameters ``metric`` and ``level`` ask for; None without a level.

    Raises:
        ConfigError: ``metric`` names no metrics term.
    """
    level: Any = term.cfg.params.get("level")
    if level is None:
        return None
    check_metric(term, env)
    return MetricLevel(term.cfg.params.get("metric", "success"), level)


def check_metric(term: ManagerTermBase, env: ManagerBasedRLEnv) -> None:
    """Check that a curriculum term's parameter ``metric``, "success" by default, names a metrics term.

    Raises:
        ConfigError: it does not.
    """
    metric, terms = term.cfg.params.get("metric", "success"), env.metrics_manager.active_terms
    if metric not in terms:
        owner, hint = type(term).__name__, suggest(metric, terms)
        raise ConfigError(f"{owner}: its metric '{metric}' is no term of env.metrics: {hint}")
