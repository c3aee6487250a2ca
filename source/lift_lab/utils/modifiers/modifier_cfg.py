"""Configurations of modifiers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from lift_lab.utils.ranges import FINITE, POSITIVE, Ranges

from ..configclass import MISSING, ConfigBase, configclass
from . import modifier


@configclass
class ModifierCfg(ConfigBase):
    """A modifier: a function of the data, or a :class:`ModifierBase` class."""

    func: Callable[..., Any] = MISSING
    """Function ``(data, **params) -> data``, or class built as ``func(cfg, data_dim, device)``."""
    params: dict[str, Any] = {}
    """Keyword arguments of a function."""


@configclass
class DigitalFilterCfg(ModifierCfg):
    """A linear digital filter (see :class:`DigitalFilter`)."""

    func: Callable[..., Any] = modifier.DigitalFilter
    A: list[float] = MISSING
    """Weights of past outputs, latest first: the denominator of the transfer function without its leading 1."""
    B: list[float] = MISSING
    """Weights of the present input and of past ones, latest first: the numerator of the transfer function."""

    _ranges: ClassVar[Ranges] = {"A B": FINITE}


@configclass
class IntegratorCfg(ModifierCfg):
    """An integral over time (see :class:`Integrator`)."""

    func: Callable[..., Any] = modifier.Integrator
    dt: float = MISSING
    """Time between two calls in s."""

    _ranges: ClassVar[Ranges] = {"dt": POSITIVE}
