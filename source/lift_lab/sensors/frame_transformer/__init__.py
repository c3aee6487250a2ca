"""Frame transformer: poses of target frames relative to a source frame."""

from .frame_transformer import FrameTransformer, FrameTransformerData
from .frame_transformer_cfg import FrameTransformerCfg, OffsetCfg

__all__ = ["FrameTransformer", "FrameTransformerCfg", "FrameTransformerData", "OffsetCfg"]
