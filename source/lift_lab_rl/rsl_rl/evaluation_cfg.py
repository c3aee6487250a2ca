"""Configuration of evaluations during a training, and of the end of the training that they decide (ours)."""

from __future__ import annotations

from typing import Any, ClassVar

from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.ranges import COUNT, COUNT_OR_ZERO, FRACTION, NOT_NEGATIVE, Range, Ranges


@configclass
class RslRlEvaluationCfg(ConfigBase):
    """Evaluate the policy during the training, on starts that it is not trained on, and end when the task is solved.

    An evaluation counts whole episodes as ``lift-lab evaluate`` does: mean action, the averaged policy where
    ``average_share`` is set, and success at any step. It runs in its own environments. The training has the same bits
    with and without it.
    """

    from_success: float | None = 0.9
    """Success rate of the training's own episodes, smoothed, from which on the policy is evaluated. None: from the
    start."""

    start_after: int = 0
    """Iterations between that success rate and the first evaluation, for example those of the schedules."""

    interval: int = 20
    """Smallest number of iterations between two evaluations."""

    max_share: float = 0.03
    """Largest share of environment steps for evaluations: steps of evaluations over steps of the training. An
    evaluation waits until its steps are within this share. An evaluation step costs less time than a training step,
    which has its part of an update."""

    episodes: int = 100
    """Episodes of an evaluation."""

    num_envs: int | None = None
    """Environments that run them; None takes one for each episode, at most 50. An evaluation of several rounds ends
    after a round if it cannot pass any more."""

    seed: int = 20_000
    """Seed of the first evaluation's starts. After an evaluation that passed, the next one has the next seed."""

    min_success: float = 1.0
    """Success rate that an evaluation has to reach to pass."""

    error_metric: str | None = None
    """Log key of the error, such as ``Metrics/object_pose/object_position_error``; None looks at no error."""

    max_error: float | None = None
    """Largest mean of :attr:`error_metric` with which an evaluation passes, in the metric's unit."""

    consecutive: int = 2
    """Evaluations in a row that have to pass. Then the training ends."""

    _ranges: ClassVar[Ranges] = {
        "from_success min_success": FRACTION,
        "start_after": COUNT_OR_ZERO,
        "interval episodes num_envs consecutive": COUNT,
        "max_share": Range(0.0, 1.0, above=True),
        "seed": Range(0, 2**31, whole=True),
        "max_error": NOT_NEGATIVE,
    }


def criteria(cfg: dict[str, Any]) -> dict[str, Any]:
    """Return the settings that say when a task is solved, as plain values.

    Args:
        cfg: entries of :class:`RslRlEvaluationCfg`.
    """
    return {name: cfg[name] for name in ("episodes", "min_success", "error_metric", "max_error", "consecutive")}
