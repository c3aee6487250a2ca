"""Config of a frame transformer."""

from __future__ import annotations

from typing import ClassVar

from lift_lab.markers import FRAME_MARKER_CFG, VisualizationMarkersCfg
from lift_lab.utils import MISSING, ConfigBase, configclass
from lift_lab.utils.ranges import FINITE, Ranges

from ..sensor_base_cfg import SensorBaseCfg
from .frame_transformer import FrameTransformer


@configclass
class OffsetCfg(ConfigBase):
    """A frame relative to its body's."""

    pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Position in m."""
    rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    """Orientation (w, x, y, z)."""

    _ranges: ClassVar[Ranges] = {"pos rot": FINITE}


@configclass
class FrameTransformerCfg(SensorBaseCfg):
    """Poses of target frames, in the world and relative to the source frame (Isaac Lab's)."""

    @configclass
    class FrameCfg:
        """A target frame."""

        prim_path: str = MISSING
        """Prim path of the body; its last part may be a regular expression for several bodies."""
        name: str | None = None
        """Name of the frame; None takes the body's."""
        offset: OffsetCfg = OffsetCfg()

    class_type: type = FrameTransformer
    prim_path: str = MISSING
    """Prim path of the source body."""
    source_frame_offset: OffsetCfg = OffsetCfg()
    """Pose of the source frame in the frame of its body."""
    target_frames: list[FrameCfg] = MISSING
    """Target frames; readings are in this order."""
    visualizer_cfg: VisualizationMarkersCfg = FRAME_MARKER_CFG.replace(prim_path="/Visuals/FrameTransformer")
    """Marker of the frames for ``debug_vis``."""
