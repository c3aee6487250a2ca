"""Cameras and ray casters."""

from typing import Annotated, Any, ClassVar, Literal

from lift_lab.markers import RAY_CASTER_MARKER_CFG, VisualizationMarkersCfg
from lift_lab.sensors.sensor_base import SensorBase
from lift_lab.sensors.sensor_base_cfg import SensorBaseCfg
from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import COUNT, COUNT_OR_ZERO, FINITE, POSITIVE_OR_INF, Ranges

from . import patterns
from .finder import place
from .patterns import PatternBaseCfg, PinholeCameraPatternCfg
from .refused import Refused
from .spawners import FisheyeCameraCfg, PinholeCameraCfg
from .table import CAMERAS, RAY_CASTERS

__all__ = [
    "Camera",
    "CameraCfg",
    "MultiMeshRayCasterCameraCfg",
    "MultiMeshRayCasterCfg",
    "RayCaster",
    "RayCasterCamera",
    "RayCasterCameraCfg",
    "RayCasterCfg",
    "TiledCamera",
    "TiledCameraCfg",
    "patterns",
]


class Camera(Refused, SensorBase):
    """A camera."""

    missing = CAMERAS


class TiledCamera(Camera):
    """A camera that draws all environments at once."""


class RayCaster(Refused, SensorBase):
    """Rays against meshes."""

    missing = RAY_CASTERS


class RayCasterCamera(RayCaster):
    """A camera of cast rays."""


@configclass
class CameraCfg(SensorBaseCfg):
    """A camera."""

    @configclass
    class OffsetCfg:
        """Pose of the camera relative to its parent."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
        convention: Literal["opengl", "ros", "world"] = "ros"

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = Camera
    offset: OffsetCfg = OffsetCfg()
    spawn: PinholeCameraCfg | FisheyeCameraCfg | None = MISSING
    depth_clipping_behavior: Literal["max", "zero", "none"] = "none"
    data_types: list[str] = ["rgb"]
    width: int = MISSING
    height: int = MISSING
    update_latest_camera_pose: bool = False
    semantic_filter: str | list[str] = "*:*"
    colorize_semantic_segmentation: bool = True
    colorize_instance_id_segmentation: bool = True
    colorize_instance_segmentation: bool = True
    semantic_segmentation_mapping: dict[str, tuple[int, int, int, int]] = {}

    _ranges: ClassVar[Ranges] = {"width height": COUNT, "semantic_segmentation_mapping": COUNT_OR_ZERO}


@configclass
class TiledCameraCfg(CameraCfg):
    """A tiled camera."""

    class_type: type = TiledCamera


@configclass
class RayCasterCfg(SensorBaseCfg):
    """Rays against meshes."""

    @configclass
    class OffsetCfg:
        """Pose of the rays' frame relative to the body's."""

        pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
        rot: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)

        _ranges: ClassVar[Ranges] = {"pos rot": FINITE}

    class_type: type = RayCaster
    mesh_prim_paths: Annotated[Any, list[str]] = MISSING
    offset: Annotated[Any, OffsetCfg] = OffsetCfg()
    attach_yaw_only: bool | None = None
    ray_alignment: Literal["base", "yaw", "world"] = "base"
    pattern_cfg: Annotated[Any, PatternBaseCfg] = MISSING
    max_distance: float = 1e6
    drift_range: tuple[float, float] = (0.0, 0.0)
    ray_cast_drift_range: dict[str, tuple[float, float]] = {"x": (0.0, 0.0), "y": (0.0, 0.0), "z": (0.0, 0.0)}
    visualizer_cfg: VisualizationMarkersCfg = RAY_CASTER_MARKER_CFG.replace(prim_path="/Visuals/RayCaster")

    _ranges: ClassVar[Ranges] = {"max_distance": POSITIVE_OR_INF, "drift_range ray_cast_drift_range": FINITE}


@configclass
class RayCasterCameraCfg(RayCasterCfg):
    """A camera of cast rays."""

    @configclass
    class OffsetCfg(RayCasterCfg.OffsetCfg):
        """Pose of the camera relative to its parent."""

        convention: Literal["opengl", "ros", "world"] = "ros"

    class_type: type = RayCasterCamera
    offset: OffsetCfg = OffsetCfg()
    data_types: list[str] = ["distance_to_image_plane"]
    depth_clipping_behavior: Literal["max", "zero", "none"] = "none"
    pattern_cfg: PinholeCameraPatternCfg = MISSING


@configclass
class MultiMeshRayCasterCfg(RayCasterCfg):
    """Rays against several meshes."""

    @configclass
    class RaycastTargetCfg:
        """One of the meshes."""

        prim_expr: str = MISSING
        is_shared: bool = False
        merge_prim_meshes: bool = True
        track_mesh_transforms: bool = True

    mesh_prim_paths: list[str | RaycastTargetCfg] = MISSING
    update_mesh_ids: bool = False
    reference_meshes: bool = True


@configclass
class MultiMeshRayCasterCameraCfg(RayCasterCameraCfg, MultiMeshRayCasterCfg):
    """A camera of such rays."""


place(__name__)
