"""Camera prims, files other than USD, and assets that differ between environments."""

from collections.abc import Callable
from typing import Annotated, Any, ClassVar, Literal, NoReturn

from lift_lab.sim.spawners.from_files import FileCfg, UsdFileCfg
from lift_lab.sim.spawners.spawner_cfg import DeformableObjectSpawnerCfg, RigidObjectSpawnerCfg, SpawnerCfg
from lift_lab.utils import MISSING, configclass
from lift_lab.utils.ranges import FINITE, NOT_NEGATIVE, POSITIVE, POSITIVE_SPAN_OR_INF, Ranges

from .finder import place
from .table import CAMERA_PRIMS, OTHER_FILES, SEVERAL_ASSETS


def spawn_camera(prim_path: str, cfg: Any) -> NoReturn:
    """Refuse to spawn a camera.

    Raises:
        ConfigError: always.
    """
    raise CAMERA_PRIMS.error(prim_path=prim_path, name=type(cfg).__name__)


def spawn_from_urdf(prim_path: str, cfg: Any) -> NoReturn:
    """Refuse to spawn a URDF file.

    Raises:
        ConfigError: always.
    """
    raise OTHER_FILES.error(prim_path=prim_path, kind="URDF", cfg=cfg)


def spawn_from_mjcf(prim_path: str, cfg: Any) -> NoReturn:
    """Refuse to spawn an MJCF file.

    Raises:
        ConfigError: always.
    """
    raise OTHER_FILES.error(prim_path=prim_path, kind="MJCF", cfg=cfg)


def spawn_multi_asset(prim_path: str, cfg: Any) -> NoReturn:
    """Refuse to spawn one of some assets.

    Raises:
        ConfigError: always.
    """
    raise SEVERAL_ASSETS.error(prim_path=prim_path, instead="spawn one of the assets_cfg instead")


def spawn_multi_usd_file(prim_path: str, cfg: Any) -> NoReturn:
    """Refuse to spawn one of some files.

    Raises:
        ConfigError: always.
    """
    raise SEVERAL_ASSETS.error(prim_path=prim_path, instead="name one of the files with UsdFileCfg")


@configclass
class PinholeCameraCfg(SpawnerCfg):
    """A pinhole camera (lengths in tenths of a scene unit, as USD has them)."""

    func: Callable = spawn_camera
    projection_type: Annotated[Any, str] = "pinhole"
    clipping_range: tuple[float, float] = (0.01, 1e6)
    focal_length: float = 24.0
    focus_distance: float = 400.0
    f_stop: float = 0.0
    horizontal_aperture: float = 20.955
    vertical_aperture: float | None = None
    horizontal_aperture_offset: float = 0.0
    vertical_aperture_offset: float = 0.0
    lock_camera: bool = True

    _ranges: ClassVar[Ranges] = {
        "clipping_range": POSITIVE_SPAN_OR_INF,
        "focal_length horizontal_aperture vertical_aperture": POSITIVE,
        "focus_distance f_stop": NOT_NEGATIVE,
        "horizontal_aperture_offset vertical_aperture_offset": FINITE,
    }


@configclass
class FisheyeCameraCfg(PinholeCameraCfg):
    """A fisheye camera."""

    projection_type: Literal["fisheyePolynomial", "fisheyeSpherical", "omniDirectionalStereo"] = "fisheyePolynomial"
    fisheye_nominal_width: float = 1936.0
    fisheye_nominal_height: float = 1216.0
    fisheye_optical_centre_x: float = 970.94244
    fisheye_optical_centre_y: float = 600.37482
    fisheye_max_fov: float = 200.0

    _ranges: ClassVar[Ranges] = {
        "fisheye_nominal_width fisheye_nominal_height fisheye_max_fov": POSITIVE,
        "fisheye_optical_centre_x fisheye_optical_centre_y": FINITE,
    }


@configclass
class MultiAssetSpawnerCfg(RigidObjectSpawnerCfg, DeformableObjectSpawnerCfg):
    """One of some assets for each environment."""

    func: Callable = spawn_multi_asset
    assets_cfg: list[SpawnerCfg] = MISSING
    random_choice: bool = True


@configclass
class MultiUsdFileCfg(UsdFileCfg):
    """One of some USD files for each environment."""

    func: Callable = spawn_multi_usd_file
    usd_path: Annotated[Any, str | list[str]] = MISSING
    random_choice: bool = True


@configclass
class UrdfFileCfg(FileCfg):
    """A URDF file."""

    func: Callable = spawn_from_urdf
    asset_path: str = MISSING
    usd_dir: str | None = None
    usd_file_name: str | None = None
    force_usd_conversion: bool = False
    make_instanceable: bool = True
    fix_base: bool = MISSING
    root_link_name: str | None = None
    link_density: float = 0.0
    merge_fixed_joints: bool = True
    convert_mimic_joints_to_normal_joints: bool = False
    joint_drive: Any = None
    collision_from_visuals: bool = False
    collider_type: str = "convex_hull"
    self_collision: bool = False
    replace_cylinders_with_capsules: bool = False

    _ranges: ClassVar[Ranges] = {"link_density": NOT_NEGATIVE}


@configclass
class MjcfFileCfg(FileCfg):
    """An MJCF file."""

    func: Callable = spawn_from_mjcf
    asset_path: str = MISSING
    usd_dir: str | None = None
    usd_file_name: str | None = None
    force_usd_conversion: bool = False
    make_instanceable: bool = True
    link_density: float = 0.0
    import_inertia_tensor: bool = True
    fix_base: bool = MISSING
    import_sites: bool = True
    self_collision: bool = False

    _ranges: ClassVar[Ranges] = {"link_density": NOT_NEGATIVE}


place(__name__)
