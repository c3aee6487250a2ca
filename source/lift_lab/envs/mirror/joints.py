"""Mirror images of an articulation's joints and bodies, from its declaration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import torch

from lift_lab.assets.articulation import ArticulationMirrorCfg
from lift_lab.assets.asset_base import as_list
from lift_lab.utils.errors import ConfigError, quote
from lift_lab.utils.mirror import MirrorMap
from lift_lab.utils.string import resolve_matching_names_values

if TYPE_CHECKING:
    from lift_lab.assets import Articulation


class JointMirror:
    """Partners, signs and offsets of the joints of one articulation.

    Attributes:
        asset: the articulation.
        positions: map of all joint positions, in the articulation's order.
    """

    def __init__(self, asset: Articulation, cfg: ArticulationMirrorCfg, owner: str):
        """Resolve the patterns.

        Args:
            asset: the articulation.
            cfg: its declaration.
            owner: path of the declaration, for messages.

        Raises:
            ConfigError: a joint has no sign, a pattern matches nothing, or the image of the image is not the joint.
        """
        self.asset, self._swaps, self._owner = asset, dict(cfg.swaps), owner
        names = asset.joint_names
        signs = dict(zip(*_by_name(cfg.signs, names, f"{owner}.signs"), strict=True))
        offsets = dict(zip(*_by_name(cfg.offsets, names, f"{owner}.offsets"), strict=True))
        missing = [name for name in names if name not in signs]
        if missing:
            raise ConfigError(f"{owner}.signs names no sign of {quote(missing)}; add 1 or -1 for each")
        for name, sign in signs.items():
            if abs(sign) != 1.0:
                raise ConfigError(f"{owner}.signs: '{name}' has {sign}; a sign is 1 or -1")
        partners = self.partners(names)
        for left, right in cfg.swaps.items():
            if not any(left in name or right in name for name in [*names, *asset.body_names]):
                raise ConfigError(f"{owner}.swaps: no joint or body has '{left}' or '{right}' in its name")
        self.positions = MirrorMap.of([signs[n] for n in names], partners, [offsets.get(n, 0.0) for n in names])
        if not self.positions.is_own_inverse():
            raise ConfigError(
                f"{owner}: the image of the image is not the robot; two joints that change places need equal signs, "
                "and an offset of a joint that keeps its sign is 0"
            )

    def partners(self, names: Sequence[str]) -> list[int]:
        """Index of the partner of each of some joints or bodies.

        Raises:
            ConfigError: a partner is not among them.
        """
        found = []
        for name in names:
            partner = self._partner(name)
            if partner not in names:
                raise ConfigError(
                    f"{self._owner}.swaps: '{name}' changes places with '{partner}', which is not among {quote(names)}"
                )
            found.append(list(names).index(partner))
        return found

    def columns(self, ids: Sequence[int] | slice, moves: bool = True) -> MirrorMap:
        """Map of some joints.

        Args:
            ids: their indices in the articulation, in the order of the numbers.
            moves: whether the numbers are positions; velocities and efforts have no offset.
        """
        chosen = as_list(ids, self.asset.num_joints)
        names = [self.asset.joint_names[i] for i in chosen]
        whole = self.positions
        offset = whole.offset[chosen] if moves else torch.zeros(len(chosen), dtype=torch.float64)
        return MirrorMap(torch.tensor(self.partners(names), dtype=torch.long), whole.factor[chosen], offset)

    def named(self, names: Sequence[str], moves: bool = True) -> MirrorMap:
        """Map of the joints of these names, as :meth:`columns` of their indices."""
        return self.columns([self.asset.joint_names.index(name) for name in names], moves)

    def _partner(self, name: str) -> str:
        for left, right in self._swaps.items():
            if left in name:
                return name.replace(left, right)
            if right in name:
                return name.replace(right, left)
        return name


def _by_name(values: dict[str, float], names: Sequence[str], owner: str) -> tuple[list[str], list[float]]:
    try:
        _, found, numbers = resolve_matching_names_values(values, names)
    except ValueError as error:
        raise ConfigError(f"{owner}: {error}") from error
    return found, numbers
