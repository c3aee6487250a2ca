"""Declaration of how an articulation mirrors in its plane y = 0."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.ranges import FINITE, Ranges

__all__ = ["ArticulationMirrorCfg"]


@configclass
class ArticulationMirrorCfg(ConfigBase):
    """Joint positions of the mirror image: ``image[j] = sign[j] * value[partner[j]] + offset[j]``.

    The plane contains the root's x and z axes. Velocities and efforts mirror in the same way, without the offset.

    Example of a robot with four legs::

        ArticulationMirrorCfg(
            signs={".*_hip_joint": -1, ".*_(thigh|calf)_joint": 1},
            swaps={"FL_": "FR_", "RL_": "RR_"},
        )
    """

    signs: dict[str, float] = {}
    """1 or -1 by joint name pattern; every joint is named by one pattern."""

    swaps: dict[str, str] = {}
    """Parts of names of joints and bodies that change places, left and right. Others are their own partners."""

    offsets: dict[str, float] = {}
    """Offset by joint name pattern in rad or m; others have 0."""

    checked_bodies: list[str] = [".*"]
    """Bodies, by name pattern, whose origins and velocities have to be mirrored in a mirrored state. This is looked at
    before a training. Leave out bodies whose origins are at different places on the left and on the right."""

    _ranges: ClassVar[Ranges] = {"signs offsets": FINITE}
