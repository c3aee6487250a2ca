"""Terrain configs with values."""
