"""Data of a rigid object."""

from __future__ import annotations

from typing import Any

from ..body_data import BodyData


class RigidObjectData(BodyData):
    """Pose and velocity of a rigid object; see :class:`BodyData` for names and shapes."""

    def __init__(self, *args: Any):
        super().__init__(*args)
        self.default_inertia = self.default_inertia[:, 0].clone()
