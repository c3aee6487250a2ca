"""Configuration of symmetry augmentation, in Isaac Lab 2.3's names."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.ranges import NOT_NEGATIVE, Ranges


@configclass
class RslRlSymmetryCfg(ConfigBase):
    """Mirrored samples and a mirror loss (Mittal et al. 2024, arXiv:2403.04359); docs/ppo.md.

    With both off, the mirror loss is only logged.
    """

    use_data_augmentation: bool = False
    """Whether mirrored samples join every minibatch."""

    use_mirror_loss: bool = False
    """Whether the policy is penalised for differing from its own mirror image."""

    data_augmentation_func: Callable | str = "lift_lab_rl.rsl_rl.symmetry:mirror_samples"
    """Function ``func(env=, obs=, actions=)`` that returns the samples and after them their mirror images, or
    ``"module:name"`` of it. Isaac Lab has no default. Ours mirrors as the task declares it, ``env.mirror``."""

    mirror_loss_coeff: float = 0.0
    """Weight of the mirror loss."""

    average_policy: bool = False
    """Whether the policy is exactly symmetric (ours): its mean action is the average of the network's action and the
    mirrored action at the mirror image. This holds in training, for checkpoints, when they act and for exported files.
    It needs the task's declared symmetry."""

    _ranges: ClassVar[Ranges] = {"mirror_loss_coeff": NOT_NEGATIVE}
