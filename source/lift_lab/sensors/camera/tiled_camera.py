"""Tiled camera: a type for configs."""

from __future__ import annotations

from .camera import Camera


class TiledCamera(Camera):
    """A type for configs; making one raises."""
