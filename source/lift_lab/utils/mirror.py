"""Mirror images of vectors: what becomes of a quantity when the world is mirrored in the plane y = 0.

The x axis points forward, z up. The plane contains both, so left and right change places.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import ClassVar, TypeVar
from weakref import WeakKeyDictionary

import torch

from .configclass import ConfigBase, configclass
from .errors import ConfigError, suggest
from .ranges import COUNT_OR_ZERO, FINITE, Ranges

__all__ = ["KINDS", "MirrorMap", "MirrorTermCfg", "kind_of", "map_of_kind", "mirrors_as"]

Term = TypeVar("Term", bound=Callable)

KINDS: dict[str, tuple[int, ...]] = {
    "same": (1,),
    "negated": (-1,),
    "vector": (1, -1, 1),
    "pseudo_vector": (-1, 1, -1),
    "quaternion": (1, -1, 1, -1),
    "pose": (1, -1, 1, 1, -1, 1, -1),
    "twist": (1, -1, 1, -1, 1, -1),
    "planar_velocity": (1, -1, -1),
    "planar_pose": (1, -1, 1, -1),
}
"""Signs of the components of the known kinds of quantities.

- ``same``: numbers that do not change, such as a height or a time.
- ``negated``: numbers that change their sign, such as a heading or a position along y.
- ``vector``: (x, y, z) of a position, a linear velocity, a force, a direction.
- ``pseudo_vector``: (x, y, z) of an angular velocity, a torque, a rotation vector.
- ``quaternion``: (w, x, y, z).
- ``pose``: position and quaternion.
- ``twist``: a vector and a pseudo-vector, for example a linear and an angular velocity.
- ``planar_velocity``: (forward, left, yaw rate).
- ``planar_pose``: (x, y, z, heading).

A term with several quantities of a kind, for example the positions of three bodies, repeats the signs.
"""


@configclass
class MirrorTermCfg(ConfigBase):
    """Mirror image of a term, number by number: ``image[i] = signs[i] * value[order[i]] + offsets[i]``."""

    signs: list[float] = []
    """Factor of each number, 1 or -1; empty for 1."""

    order: list[int] = []
    """Index of the number that each number of the image is made of; empty for the same order."""

    offsets: list[float] = []
    """Number to add to each; empty for 0."""

    _ranges: ClassVar[Ranges] = {"signs offsets": FINITE, "order": COUNT_OR_ZERO}


def image_of(values: torch.Tensor, index: torch.Tensor, factor: torch.Tensor, offset: torch.Tensor) -> torch.Tensor:
    """Return ``factor[i] * values[..., index[i]] + offset[i]`` as a new tensor of shape (..., dim)."""
    return values.index_select(-1, index).mul_(factor).add_(offset)


class MirrorMap:
    """Mirror image of a vector: ``image[i] = factor[i] * value[index[i]] + offset[i]``.

    Attributes:
        index: which number each number of the image is made of, shape (dim,).
        factor: its factor, shape (dim,).
        offset: what is added, shape (dim,).
    """

    def __init__(self, index: torch.Tensor, factor: torch.Tensor, offset: torch.Tensor):
        """Keep the three tensors."""
        self.index, self.factor, self.offset = index, factor, offset

    @classmethod
    def of(
        cls, factor: Sequence[float], index: Sequence[int] | None = None, offset: Sequence[float] | None = None
    ) -> MirrorMap:
        """A map from numbers, on the CPU.

        Args:
            factor: of each number.
            index: of each number; None for the same order.
            offset: of each number; None for 0.
        """
        count = len(factor)
        with torch.inference_mode(False):
            return cls(
                torch.tensor(list(range(count)) if index is None else list(index), dtype=torch.long),
                torch.tensor(list(factor), dtype=torch.float64),
                torch.tensor([0.0] * count if offset is None else list(offset), dtype=torch.float64),
            )

    @classmethod
    def cat(cls, maps: Sequence[MirrorMap]) -> MirrorMap:
        """The map of the vectors one after the other."""
        starts = [0]
        for one in maps:
            starts.append(starts[-1] + len(one))
        index = [one.index + start for one, start in zip(maps, starts, strict=False)]
        return cls(torch.cat(index), torch.cat([m.factor for m in maps]), torch.cat([m.offset for m in maps]))

    def __len__(self) -> int:
        return len(self.index)

    def __call__(self, values: torch.Tensor) -> torch.Tensor:
        """The mirror image.

        Args:
            values: shape (..., dim).

        Returns:
            A new tensor of that shape.
        """
        return image_of(values, self.index, self.factor, self.offset)

    def of_parts(self, partners: Sequence[int]) -> MirrorMap:
        """Map of several such vectors one after the other, which change places.

        Args:
            partners: which vector the image of each is made of.
        """
        index = torch.cat([self.index + partner * len(self) for partner in partners])
        return MirrorMap(index, self.factor.repeat(len(partners)), self.offset.repeat(len(partners)))

    def in_units(self, unit: torch.Tensor | float, zero: torch.Tensor | float = 0.0) -> MirrorMap:
        """The same map for other numbers ``x``, where the vector is ``unit * x + zero``.

        Args:
            unit: shape (dim,), or one number.
            zero: shape (dim,), or one number.
        """
        unit = torch.as_tensor(unit, dtype=torch.float64).cpu().expand(len(self))
        zero = torch.as_tensor(zero, dtype=torch.float64).cpu().expand(len(self))
        factor = self.factor * unit[self.index] / unit
        offset = (self.factor * zero[self.index] + self.offset - zero) / unit
        return MirrorMap(self.index, factor, torch.where(offset.abs() < 1e-12, 0.0, offset))

    def is_own_inverse(self, tolerance: float = 1e-6) -> bool:
        """Whether the image of the image is the vector."""
        back = self.index[self.index]
        factor = self.factor * self.factor[self.index]
        offset = self.factor * self.offset[self.index] + self.offset
        return (
            torch.equal(back, torch.arange(len(self)))
            and bool(((factor - 1.0).abs() < tolerance).all())
            and bool((offset.abs() < tolerance).all())
        )

    def to(self, device: str | torch.device) -> MirrorMap:
        """This map for float32 tensors of a device."""
        with torch.inference_mode(False):
            return MirrorMap(self.index.to(device), self.factor.to(device).float(), self.offset.to(device).float())


def map_of_kind(kind: str | MirrorTermCfg, dim: int, owner: str) -> MirrorMap:
    """Map of a term of a declared kind.

    Args:
        kind: a name of :data:`KINDS`, or what becomes of each number.
        dim: numbers of the term.
        owner: the term, for messages.

    Raises:
        ConfigError: there is no such kind, or it has another number of components.
    """
    if isinstance(kind, str):
        if kind not in KINDS:
            raise ConfigError(f"{owner}: there is no kind of mirror image '{kind}'; {suggest(kind, KINDS)}")
        signs = KINDS[kind]
        if dim % len(signs):
            raise ConfigError(f"{owner}: it has {dim} numbers, a '{kind}' has {len(signs)}")
        return MirrorMap.of(signs * (dim // len(signs)))
    given = {"signs": kind.signs, "order": kind.order, "offsets": kind.offsets}
    for name, values in given.items():
        if values and len(values) != dim:
            raise ConfigError(f"{owner}: it has {dim} numbers, {name} has {len(values)}")
    if any(abs(sign) != 1.0 for sign in kind.signs):
        raise ConfigError(f"{owner}: signs are 1 or -1, not {kind.signs}")
    if kind.order and sorted(kind.order) != list(range(dim)):
        raise ConfigError(f"{owner}: order names each of 0 to {dim - 1} once, not {kind.order}")
    found = MirrorMap.of(kind.signs or [1.0] * dim, kind.order or None, kind.offsets or None)
    if not found.is_own_inverse():
        raise ConfigError(f"{owner}: the image of the image is not the value; check signs, order and offsets")
    return found


_KIND_OF: WeakKeyDictionary[Callable, str] = WeakKeyDictionary()


def mirrors_as(kind: str) -> Callable[[Term], Term]:
    """Declare the kind of an observation term, beside its function.

    Args:
        kind: a name of :data:`KINDS`.

    Raises:
        ConfigError: there is no such kind.
    """
    if kind not in KINDS:
        raise ConfigError(f"mirrors_as: there is no kind of mirror image '{kind}'; {suggest(kind, KINDS)}")

    def note(term: Term) -> Term:
        _KIND_OF[term] = kind
        return term

    return note


def kind_of(term: Callable) -> str | None:
    """Return the kind that :func:`mirrors_as` declared; None for none."""
    return _KIND_OF.get(term)
