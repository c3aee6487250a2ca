"""State of an asset, computed on demand and kept until the engine moves on."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import torch

from lift_lab.utils.attributes import EntityData


class cached(property):
    """A read-only property computed once per engine state (see :meth:`AssetData.invalidate`)."""

    def __init__(self, compute: Callable[[Any], torch.Tensor]):
        name = compute.__name__

        def read(self: AssetData) -> torch.Tensor:
            value = self._cache.get(name)
            if value is None:
                value = compute(self)
                self._cache[name] = value
            return value

        super().__init__(read, doc=compute.__doc__)


class AssetData(EntityData):
    """State of an asset, kept until the engine moves on."""

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_cache"})

    _cache: dict[str, torch.Tensor]

    def on_state_loaded(self) -> None:
        """Forget what was computed before a saved state was loaded."""
        self._cache.clear()

    def invalidate(self) -> None:
        """Forget cached values: the engine's state has changed."""
        self._cache.clear()

    def update(self, dt: float) -> None:
        """Isaac Lab's name of :meth:`invalidate`."""
        self._cache.clear()
