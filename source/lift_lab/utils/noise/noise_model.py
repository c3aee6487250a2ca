"""Noise functions, and noise models that keep state between calls."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

from ..errors import ConfigError, suggest

if TYPE_CHECKING:
    from . import noise_cfg


def constant_noise(data: torch.Tensor, cfg: noise_cfg.ConstantNoiseCfg) -> torch.Tensor:
    """Apply ``cfg.bias``. Shape is that of ``data``."""
    return _apply(data, _on_device(cfg.bias, data), cfg.operation)


def uniform_noise(data: torch.Tensor, cfg: noise_cfg.UniformNoiseCfg) -> torch.Tensor:
    """Apply noise that is uniform in [cfg.n_min, cfg.n_max). Shape is that of ``data``."""
    n_min, n_max = _on_device(cfg.n_min, data), _on_device(cfg.n_max, data)
    return _apply(data, torch.rand_like(data) * (n_max - n_min) + n_min, cfg.operation)


def gaussian_noise(data: torch.Tensor, cfg: noise_cfg.GaussianNoiseCfg) -> torch.Tensor:
    """Apply normally distributed noise of ``cfg.mean`` and ``cfg.std``. Shape is that of ``data``."""
    noise = torch.randn_like(data) * _on_device(cfg.std, data) + _on_device(cfg.mean, data)
    return _apply(data, noise, cfg.operation)


def _on_device(value: torch.Tensor | float, data: torch.Tensor) -> torch.Tensor | float:
    return value.to(data.device) if isinstance(value, torch.Tensor) else value


def _apply(data: torch.Tensor, noise: torch.Tensor | float, operation: str) -> torch.Tensor:
    if operation == "add":
        return data + noise
    if operation == "scale":
        return data * noise
    if operation == "abs":
        return torch.zeros_like(data) + noise
    raise ConfigError(f"unknown noise operation '{operation}'; {suggest(operation, ('add', 'scale', 'abs'))}")


class NoiseModel:
    """Noise drawn afresh at every call; base of the models with state."""

    def __init__(self, noise_model_cfg: noise_cfg.NoiseModelCfg, num_envs: int, device: torch.device | str):
        """
        Args:
            noise_model_cfg: the configuration.
            num_envs: number of environments.
            device: device of the data.
        """
        self._noise_model_cfg = noise_model_cfg
        self._num_envs = num_envs
        self._device = device

    def reset(self, env_ids: Sequence[int] | torch.Tensor | None = None) -> None:
        """Reset the state of some environments (None: all). Without state there is nothing to do."""

    def __call__(self, data: torch.Tensor) -> torch.Tensor:
        """Data with noise. Shape is (num_envs, ...)."""
        cfg = self._noise_model_cfg.noise_cfg
        return cfg.func(data, cfg)


class NoiseModelWithAdditiveBias(NoiseModel):
    """Noise, and a bias per environment that is drawn at every reset."""

    def __init__(
        self, noise_model_cfg: noise_cfg.NoiseModelWithAdditiveBiasCfg, num_envs: int, device: torch.device | str
    ):
        super().__init__(noise_model_cfg, num_envs, device)
        self._bias_cfg = noise_model_cfg.bias_noise_cfg
        self._per_component = noise_model_cfg.sample_bias_per_component
        self._bias = torch.zeros(num_envs, 1, device=device)

    def reset(self, env_ids: Sequence[int] | torch.Tensor | None = None) -> None:
        """Draw the bias of some environments (None: all)."""
        ids = slice(None) if env_ids is None else env_ids
        self._bias[ids] = self._bias_cfg.func(self._bias[ids], self._bias_cfg)

    def __call__(self, data: torch.Tensor) -> torch.Tensor:
        """Data with noise and bias. Shape is (num_envs, num_components)."""
        if self._per_component and self._bias.shape[-1] != data.shape[-1]:
            # the number of components is first known here
            self._bias = self._bias.repeat(1, data.shape[-1])
            self.reset()
        return super().__call__(data) + self._bias
