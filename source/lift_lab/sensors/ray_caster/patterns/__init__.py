"""Ray patterns: configs only."""

from .patterns_cfg import BpearlPatternCfg, GridPatternCfg, LidarPatternCfg, PatternBaseCfg, PinholeCameraPatternCfg

__all__ = ["BpearlPatternCfg", "GridPatternCfg", "LidarPatternCfg", "PatternBaseCfg", "PinholeCameraPatternCfg"]
