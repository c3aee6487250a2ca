"""Configurations of noise."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Literal

import torch

from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, Ranges

from ..configclass import MISSING, ConfigBase, configclass
from . import noise_model


@configclass
class NoiseCfg(ConfigBase):
    """Base of the noise configurations."""

    func: Callable[..., torch.Tensor] = MISSING
    """Function ``(data, cfg) -> data`` that applies the noise. Shapes are the same."""
    operation: Literal["add", "scale", "abs"] = "add"
    """Whether noise is added to the data, multiplied with it, or takes its place."""


@configclass
class ConstantNoiseCfg(NoiseCfg):
    """A constant."""

    func: Callable[..., torch.Tensor] = noise_model.constant_noise
    bias: torch.Tensor | float = 0.0
    """The constant; a tensor broadcasts against the data."""

    _ranges: ClassVar[Ranges] = {"bias": FINITE}


@configclass
class UniformNoiseCfg(NoiseCfg):
    """Uniformly distributed noise."""

    func: Callable[..., torch.Tensor] = noise_model.uniform_noise
    n_min: torch.Tensor | float = -1.0
    """Least value; a tensor broadcasts against the data."""
    n_max: torch.Tensor | float = 1.0
    """Greatest value; a tensor broadcasts against the data."""

    _ranges: ClassVar[Ranges] = {"n_min n_max": FINITE}


@configclass
class GaussianNoiseCfg(NoiseCfg):
    """Normally distributed noise."""

    func: Callable[..., torch.Tensor] = noise_model.gaussian_noise
    mean: torch.Tensor | float = 0.0
    """Mean; a tensor broadcasts against the data."""
    std: torch.Tensor | float = 1.0
    """Standard deviation; a tensor broadcasts against the data."""

    _ranges: ClassVar[Ranges] = {"mean": FINITE, "std": NOT_NEGATIVE}


@configclass
class NoiseModelCfg(ConfigBase):
    """Noise that keeps state between calls."""

    class_type: type = noise_model.NoiseModel
    """Class of the noise model, built as ``class_type(cfg, num_envs=, device=)``."""
    noise_cfg: NoiseCfg = MISSING
    """Noise that is drawn at every call."""
    func: Callable[[torch.Tensor], torch.Tensor] | None = None
    """The built model; set by the observation manager."""


@configclass
class NoiseModelWithAdditiveBiasCfg(NoiseModelCfg):
    """Noise and, on top of it, a bias that is drawn at every reset."""

    class_type: type = noise_model.NoiseModelWithAdditiveBias
    bias_noise_cfg: NoiseCfg = MISSING
    """Noise of the bias. Operation "abs" draws a new bias at each reset; "add" adds to the last one."""
    sample_bias_per_component: bool = True
    """Whether every component of the data has its own bias, rather than one for all."""
