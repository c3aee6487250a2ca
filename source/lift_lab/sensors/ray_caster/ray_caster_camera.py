"""Ray caster camera: a type for configs."""

from __future__ import annotations

from .ray_caster import RayCaster


class RayCasterCamera(RayCaster):
    """A type for configs; making one raises."""
