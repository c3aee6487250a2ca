"""Declaration of a task's mirror symmetry."""

from __future__ import annotations

from lift_lab.assets.articulation import ArticulationMirrorCfg
from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.mirror import MirrorTermCfg

__all__ = ["MirrorCfg"]


@configclass
class MirrorCfg(ConfigBase):
    """Mirror image of a task in the plane y = 0 of each environment.

    The task itself has to be symmetric: its rewards, resets and command ranges. Terms of :mod:`lift_lab.envs.mdp`
    and of the shipped tasks are known. A term of your own needs a declaration: here, or with
    :func:`~lift_lab.utils.mirror.mirrors_as` beside its function. A declaration is a kind of
    :data:`~lift_lab.utils.mirror.KINDS`, such as ``"vector"``, or a
    :class:`~lift_lab.utils.mirror.MirrorTermCfg`. A declared term takes the place of a known one.
    """

    assets: dict[str, ArticulationMirrorCfg] = {}
    """Joints of each articulation, by its name in the scene."""

    observations: dict[str, str | MirrorTermCfg] = {}
    """Observation terms, by ``name`` or ``group/name``: the value that the network sees, without history."""

    actions: dict[str, str | MirrorTermCfg] = {}
    """Action terms by name: the raw action."""

    commands: dict[str, str | MirrorTermCfg] = {}
    """Command terms by name."""
