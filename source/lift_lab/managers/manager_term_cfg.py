"""Configs of the terms that each manager takes. A config is data: the managers resolve and call it.

Field names and defaults are those of Isaac Lab 2.3 (``isaaclab.managers.manager_term_cfg``).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Literal

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.modifiers import ModifierCfg
from lift_lab.utils.noise import NoiseCfg, NoiseModelCfg
from lift_lab.utils.ranges import (
    COUNT_OR_ZERO,
    FINITE,
    POSITIVE_SPAN,
    POSITIVE_SPAN_OR_INF,
    SPAN_OR_INF,
    WHOLE,
    Range,
    Ranges,
)

_CLIP = Range(ascending=True, infinite=True, open_ended=True)
"""(low, high), of which one may be None, for no limit."""


@configclass
class ManagerTermBaseCfg(ConfigBase):
    """A function or class with the arguments it is called with."""

    func: Callable | str = MISSING
    """Function that computes the term. Either a function ``func(env, **params)``, or a sub-class of
    :class:`~lift_lab.managers.ManagerTermBase` (built once as ``func(cfg=..., env=...)``, then called the same way), or
    a string ``"module:name"`` of either. Curriculum and event terms are called with ``(env, env_ids, **params)``."""

    params: dict[str, Any] = {}
    """Keyword arguments of the call. A :class:`~lift_lab.managers.SceneEntityCfg` among them, also inside a
    list, tuple or dict, is resolved against the scene first."""


@configclass
class RecorderTermCfg(ConfigBase):
    """One thing to record."""

    class_type: type = MISSING
    """Sub-class of :class:`~lift_lab.managers.RecorderTerm`."""


@configclass
class ActionTermCfg(ConfigBase):
    """One slice of the action vector."""

    class_type: type = MISSING
    """Sub-class of :class:`~lift_lab.managers.ActionTerm`."""

    asset_name: str = MISSING
    """Name of the scene entity that the actions drive."""

    debug_vis: bool = False
    """Whether viewers draw the term's markers."""

    clip: dict[str, tuple] | None = None
    """Range ``(lower, upper)`` of the processed action by joint-name pattern; None clips nothing."""

    _ranges: ClassVar[Ranges] = {"clip": SPAN_OR_INF}


@configclass
class CommandTermCfg(ConfigBase):
    """One command, resampled on a timer."""

    class_type: type = MISSING
    """Sub-class of :class:`~lift_lab.managers.CommandTerm`."""

    resampling_time_range: tuple[float, float] = MISSING
    """Seconds a command is held, drawn uniformly from this range."""

    debug_vis: bool = False
    """Whether viewers draw the term's markers."""

    _ranges: ClassVar[Ranges] = {"resampling_time_range": POSITIVE_SPAN_OR_INF}


@configclass
class CurriculumTermCfg(ManagerTermBaseCfg):
    """A change of the task with progress; ``func(env, env_ids, **params)`` returns the state to log or
    None."""

    training_only: bool = False
    """Whether the term is only for training: ``lift-lab evaluate`` and ``lift-lab play`` leave it out, unless an
    override names it."""


def leave_out_training_only(env_cfg: Any, is_kept: Callable[[str], bool] = lambda name: False) -> None:
    """Replace curriculum terms that are only for training by None.

    Args:
        env_cfg: configuration of an environment; changed in place.
        is_kept: whether the term of a name stays all the same.
    """
    curriculum = getattr(env_cfg, "curriculum", None) or {}
    terms = curriculum if isinstance(curriculum, dict) else vars(curriculum)
    for name, term in terms.items():
        if isinstance(term, CurriculumTermCfg) and term.training_only and not is_kept(name):
            terms[name] = None


@configclass
class ObservationTermCfg(ManagerTermBaseCfg):
    """One observation: func, then modifiers, noise, clip, scale, history, in this order."""

    modifiers: list[ModifierCfg] | None = None
    """Functions of the value, applied one after the other."""

    noise: NoiseCfg | NoiseModelCfg | None = None
    """Corruption of the value; dropped where the group has ``enable_corruption=False``."""

    clip: tuple[float, float] | None = None
    """Range (low, high) that the value is clipped to after the noise."""

    scale: tuple[float, ...] | float | None = None
    """Factor on the clipped value: one number, or one for each entry of the last dimension."""

    history_length: int = 0
    """Number of values that are kept, the current one included; 0 keeps none. The first value after a reset fills the
    whole history; the oldest comes first."""

    flatten_history_dim: bool = True
    """Whether a history of shape (num_envs, length, ...) is returned as (num_envs, length * ...)."""

    _ranges: ClassVar[Ranges] = {"clip": _CLIP, "scale": FINITE, "history_length": COUNT_OR_ZERO}


@configclass
class ObservationGroupCfg(ConfigBase):
    """Observation terms that are returned together; terms are added as fields of a sub-class."""

    concatenate_terms: bool = True
    """Whether the terms become one tensor; otherwise the group is a dict of tensors by term name."""

    concatenate_dim: int = -1
    """Dimension to concatenate along, not counting the environments."""

    enable_corruption: bool = False
    """Whether the terms' noise is applied."""

    history_length: int | None = None
    """History of every term in the group, in place of the terms' own setting; None leaves theirs."""

    flatten_history_dim: bool = True
    """Flattening of every term in the group; used only where the group sets ``history_length``."""

    _ranges: ClassVar[Ranges] = {"concatenate_dim": WHOLE, "history_length": COUNT_OR_ZERO}


@configclass
class EventTermCfg(ManagerTermBaseCfg):
    """A change of the simulation, ``func(env, env_ids, **params)``, made whenever its mode is applied."""

    mode: str = MISSING
    """Mode: ``"prestartup"``, ``"startup"``, ``"reset"``, ``"interval"``, or your own name that your environment passes
    to :meth:`~lift_lab.managers.EventManager.apply`."""

    interval_range_s: tuple[float, float] | None = None
    """Mode ``"interval"``: seconds between two applications, drawn uniformly."""

    is_global_time: bool = False
    """Mode ``"interval"``: one timer for all environments, which a reset leaves alone, in place of one for
    each."""

    min_step_count_between_reset: int = 0
    """Mode ``"reset"``: environment steps that must pass between two applications to the same environment."""

    _ranges: ClassVar[Ranges] = {"interval_range_s": POSITIVE_SPAN, "min_step_count_between_reset": COUNT_OR_ZERO}


@configclass
class RewardTermCfg(ManagerTermBaseCfg):
    """A reward of shape (num_envs,), per second."""

    weight: float = MISSING
    """Factor on the value; 0 skips the call."""

    _ranges: ClassVar[Ranges] = {"weight": FINITE}


@configclass
class MetricsTermCfg(ManagerTermBaseCfg):
    """A number of each episode for the log, made from a value of shape (num_envs,) at every step."""

    reduce: Literal["last", "max", "mean", "sum", "first"] = "mean"
    """Reduction of the values of an episode's steps to one. ``"first"`` is the first value that is not NaN; the log's
    mean is then over the episodes that had one."""

    log_as: str | None = None
    """Name in the log, after ``Metrics/``, such as ``"object_pose/error"``; None takes the term's name."""


@configclass
class TerminationTermCfg(ManagerTermBaseCfg):
    """A boolean of shape (num_envs,) that ends episodes."""

    time_out: bool = False
    """Whether the end is a truncation, whose return is bootstrapped, and not a terminal state."""
