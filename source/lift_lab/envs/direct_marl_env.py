"""Isaac Lab's module path of this type."""

from .direct import DirectMARLEnv

__all__ = ["DirectMARLEnv"]
