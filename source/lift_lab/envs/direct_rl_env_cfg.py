"""Isaac Lab's module path of this type."""

from .direct import DirectRLEnvCfg

__all__ = ["DirectRLEnvCfg"]
