"""Data of a rigid object."""

from __future__ import annotations

from ..body_data import BodyData


class RigidObjectData(BodyData):
    """Pose and velocity of a rigid object; see :class:`BodyData` for names and shapes."""
