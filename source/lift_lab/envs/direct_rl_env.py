"""Isaac Lab's module path of this type."""

from .direct import DirectRLEnv

__all__ = ["DirectRLEnv"]
