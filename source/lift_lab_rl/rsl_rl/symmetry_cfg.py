"""Configuration of symmetry augmentation, in Isaac Lab 2.3's names."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import NOT_NEGATIVE, Ranges


@configclass
class RslRlSymmetryCfg(ConfigBase):
    """Mirrored samples and a mirror loss (Mittal et al. 2024)."""

    use_data_augmentation: bool = False
    """Whether mirrored samples join every minibatch."""

    use_mirror_loss: bool = False
    """Whether the policy is penalised for differing from its own mirror image."""

    data_augmentation_func: Callable = MISSING
    """``func(env=, obs=, actions=)`` returning the samples with their mirror images appended."""

    mirror_loss_coeff: float = 0.0
    """Weight of the mirror loss."""

    _ranges: ClassVar[Ranges] = {"mirror_loss_coeff": NOT_NEGATIVE}
