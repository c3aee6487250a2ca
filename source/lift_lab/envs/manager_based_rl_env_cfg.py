"""Config of a reinforcement learning environment."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import POSITIVE, Ranges

from .manager_based_env_cfg import ManagerBasedEnvCfg

__all__ = [
    "ManagerBasedRLEnvCfg",
]


@configclass
class ManagerBasedRLEnvCfg(ManagerBasedEnvCfg):
    """Config of :class:`ManagerBasedRLEnv`."""

    is_finite_horizon: bool = False
    """Whether the time limit is the end of the task. If so, the learner's wrapper does not report time-outs, and the
    learner does not bootstrap the value of the last state."""
    episode_length_s: float = MISSING
    """Length of an episode in s; it takes ceil(length / (decimation * sim.dt)) steps."""
    rewards: Annotated[Any, object] = MISSING
    """Reward terms."""
    terminations: Annotated[Any, object] = MISSING
    """Termination terms."""
    curriculum: Annotated[Any, object | None] = None
    """Curriculum terms."""
    commands: Annotated[Any, object | None] = None
    """Command terms."""
    metrics: Annotated[Any, object | None] = None
    """Metrics terms."""

    _ranges: ClassVar[Ranges] = {"episode_length_s": POSITIVE}
