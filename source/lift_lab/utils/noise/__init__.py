"""Noise on tensors, as configurations that carry their function (Isaac Lab's ``utils.noise``).

.. code-block:: python

    cfg = AdditiveGaussianNoiseCfg(mean=0.0, std=0.1)
    noisy = cfg.func(data, cfg)
"""

from .noise_cfg import (
    ConstantNoiseCfg,
    GaussianNoiseCfg,
    NoiseCfg,
    NoiseModelCfg,
    NoiseModelWithAdditiveBiasCfg,
    UniformNoiseCfg,
)
from .noise_model import NoiseModel, NoiseModelWithAdditiveBias, constant_noise, gaussian_noise, uniform_noise

__all__ = [
    "AdditiveGaussianNoiseCfg",
    "AdditiveUniformNoiseCfg",
    "ConstantBiasNoiseCfg",
    "ConstantNoiseCfg",
    "GaussianNoiseCfg",
    "NoiseCfg",
    "NoiseModel",
    "NoiseModelCfg",
    "NoiseModelWithAdditiveBias",
    "NoiseModelWithAdditiveBiasCfg",
    "UniformNoiseCfg",
    "constant_noise",
    "gaussian_noise",
    "uniform_noise",
]

ConstantBiasNoiseCfg = ConstantNoiseCfg
"""Older name of :class:`ConstantNoiseCfg` in Isaac Lab."""
AdditiveUniformNoiseCfg = UniformNoiseCfg
"""Older name of :class:`UniformNoiseCfg` in Isaac Lab."""
AdditiveGaussianNoiseCfg = GaussianNoiseCfg
"""Older name of :class:`GaussianNoiseCfg` in Isaac Lab."""
