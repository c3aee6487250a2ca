"""Isaac Lab's module path of this type."""

from .direct import DirectMARLEnvCfg

__all__ = ["DirectMARLEnvCfg"]
