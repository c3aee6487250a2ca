"""Ray patterns: configs only."""

from .patterns_cfg import GridPatternCfg, LidarPatternCfg, PatternBaseCfg, PinholeCameraPatternCfg

__all__ = ["GridPatternCfg", "LidarPatternCfg", "PatternBaseCfg", "PinholeCameraPatternCfg"]
