"""The frame in the browser that holds everything drawn, so that all of it can be moved at once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import viser

WORLD = "/world"
"""Path in the scene of the frame of the world. Every layer draws below it."""


class World:
    """Shifts the whole scene in front of the cameras.

    A camera that follows a body would have to be moved while the user turns it. To move the scene instead leaves the
    camera to the user.
    """

    def __init__(self, server: viser.ViserServer):
        """Make the frame at the origin."""
        self._frame = server.scene.add_frame(WORLD, show_axes=False)
        self._shift = np.zeros(3)

    @property
    def shift(self) -> np.ndarray:
        """Offset added to world positions where they are drawn, in m, shape (3,)."""
        return self._shift.copy()

    def from_drawn(self, point: Sequence[float]) -> np.ndarray:
        """Position in the world of a point of the picture, in m, shape (3,)."""
        return np.asarray(point, dtype=float) - self._shift

    def move(self, shift: np.ndarray) -> None:
        """Draw the world shifted by a vector in m, shape (3,)."""
        if not np.array_equal(shift, self._shift):
            self._shift = np.asarray(shift, dtype=float).copy()
            self._frame.position = self._shift
