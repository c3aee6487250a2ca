"""Groups of markers: shapes that are drawn over a scene, and their poses. Viewers read them; without one nothing is
drawn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any
from weakref import WeakKeyDictionary

import torch

from lift_lab.drawing.shapes import Primitive
from lift_lab.sim import SimulationContext, SpawnerCfg
from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.saved_state import Stateless

from .drawn import primitives

__all__ = ["VisualizationMarkers", "VisualizationMarkersCfg"]


@configclass
class VisualizationMarkersCfg(ConfigBase):
    """Shapes drawn over a scene, each a spawner by name."""

    prim_path: str = MISSING
    """Isaac Lab's prim path of the markers. A label here."""
    markers: Annotated[Any, dict[str, SpawnerCfg]] = MISSING
    """Marker name -> its shape."""


class VisualizationMarkers(Stateless):
    """Instances of a few shapes (Isaac Lab's ``VisualizationMarkers``).

    Holds poses only: a viewer finds the groups of a simulation with :meth:`of` and draws them.
    """

    _groups: WeakKeyDictionary[SimulationContext, list[VisualizationMarkers]] = WeakKeyDictionary()

    def __init__(self, cfg: VisualizationMarkersCfg):
        """Make a group without instances in the newest simulation.

        Raises:
            ConfigError: the config has no shapes, or there is no simulation yet.
        """
        if not cfg.markers:
            raise ConfigError(f"markers '{cfg.prim_path}' have no shapes")
        sim = SimulationContext.instance()
        if sim is None:
            raise ConfigError("make a SimulationContext before VisualizationMarkers")
        self.cfg = cfg
        self._visible = True
        self.positions_w = torch.zeros(0, 3)
        """Positions of the instances in m, shape (count, 3)."""
        self.quats_w = torch.zeros(0, 4)
        """Their orientations (w, x, y, z), shape (count, 4)."""
        self.scales = torch.zeros(0, 3)
        """Their scales on top of the shape's own, shape (count, 3)."""
        self.marker_indices = torch.zeros(0, dtype=torch.long)
        """Which shape each is, by its place in the config, shape (count,)."""
        self._primitives: list[list[Primitive]] | None = None
        self._groups.setdefault(sim, []).append(self)

    @classmethod
    def of(cls, sim: SimulationContext) -> list[VisualizationMarkers]:
        """The groups of a simulation, oldest first."""
        return list(cls._groups.get(sim, ()))

    @property
    def num_prototypes(self) -> int:
        """Number of shapes."""
        return len(self.cfg.markers)

    @property
    def count(self) -> int:
        """Number of instances."""
        return len(self.positions_w)

    def set_visibility(self, visible: bool) -> None:
        """Show or hide all instances."""
        self._visible = visible

    def is_visible(self) -> bool:
        """Whether they are shown."""
        return self._visible

    @property
    def primitives(self) -> list[list[Primitive]]:
        """Primitives that draw each shape in videos, in the config's order; the same lists at every call."""
        if self._primitives is None:
            self._primitives = [primitives(cfg) for cfg in self.cfg.markers.values()]
        return self._primitives

    def visualize(
        self,
        translations: torch.Tensor | None = None,
        orientations: torch.Tensor | None = None,
        scales: torch.Tensor | None = None,
        marker_indices: Sequence[int] | torch.Tensor | None = None,
    ) -> None:
        """Place the instances.

        Arguments that are None keep their values. If the number of instances changes, they become no rotation, a scale
        of 1, and the first shape.

        Args:
            translations: positions in the world in m, shape (count, 3).
            orientations: (w, x, y, z), shape (count, 4).
            scales: shape (count, 3).
            marker_indices: shape of each, in the config's order, shape (count,).

        Raises:
            ValueError: a shape does not fit the number of instances, or an index is of no shape.
        """
        indices = None if marker_indices is None else torch.as_tensor(marker_indices, dtype=torch.long)
        given = {"translations": translations, "orientations": orientations, "scales": scales, "indices": indices}
        counts = {name: len(value) for name, value in given.items() if value is not None}
        count = next(iter(counts.values()), self.count)
        widths = {"translations": (3,), "orientations": (4,), "scales": (3,), "indices": ()}
        for name, value in given.items():
            if value is not None and tuple(value.shape) != (count, *widths[name]):
                raise ValueError(f"{name}: expected shape {(count, *widths[name])}, got {tuple(value.shape)}")
        if indices is not None and count and not 0 <= int(indices.min()) <= int(indices.max()) < self.num_prototypes:
            raise ValueError(f"marker_indices must be in [0, {self.num_prototypes})")
        if count != self.count:
            self.positions_w = torch.zeros(count, 3)
            self.quats_w = torch.tensor((1.0, 0.0, 0.0, 0.0)).repeat(count, 1)
            self.scales = torch.ones(count, 3)
            self.marker_indices = torch.zeros(count, dtype=torch.long)
        self.positions_w = self.positions_w if translations is None else translations.detach()
        self.quats_w = self.quats_w if orientations is None else orientations.detach()
        self.scales = self.scales if scales is None else scales.detach()
        self.marker_indices = self.marker_indices if indices is None else indices
