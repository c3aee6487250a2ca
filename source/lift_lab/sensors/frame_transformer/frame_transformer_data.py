"""Isaac Lab's module path of the frame transformer's readings."""

from .frame_transformer import FrameTransformerData

__all__ = ["FrameTransformerData"]
