"""Changes to a tensor that an observation term may ask for, with or without state (Isaac Lab's ``utils.modifiers``).

.. code-block:: python

    cfg = ModifierCfg(func=clip, params={"bounds": (0.0, None)})
    clipped = cfg.func(data, **cfg.params)

    cfg = DigitalFilterCfg(A=[0.0], B=[0.0, 1.0])  # a delay of one step
    delay = cfg.func(cfg, data.shape, "cpu")
    delayed = delay(data)
"""

from .modifier import DigitalFilter, Integrator, bias, clip, scale
from .modifier_base import ModifierBase
from .modifier_cfg import DigitalFilterCfg, IntegratorCfg, ModifierCfg

__all__ = [
    "DigitalFilter",
    "DigitalFilterCfg",
    "Integrator",
    "IntegratorCfg",
    "ModifierBase",
    "ModifierCfg",
    "bias",
    "clip",
    "scale",
]
