"""Collections of rigid objects, and surface grippers."""

from typing import Any, ClassVar

from lift_lab.assets import AssetBase, AssetBaseCfg, RigidObjectCfg
from lift_lab.utils import MISSING, configclass
from lift_lab.utils.errors import quote
from lift_lab.utils.ranges import NOT_NEGATIVE_OR_INF, Ranges

from .finder import place
from .refused import Refused
from .table import COLLECTIONS, SURFACE_GRIPPERS


class RigidObjectCollection(AssetBase):
    """Several rigid objects in one asset."""

    def __init__(self, cfg: Any):
        """Refuse.

        Raises:
            ConfigError: always.
        """
        raise COLLECTIONS.error(objects=quote(cfg.rigid_objects))


@configclass
class RigidObjectCollectionCfg(AssetBaseCfg):
    """Several rigid objects in one asset."""

    class_type: type = RigidObjectCollection
    prim_path: str = ""
    rigid_objects: dict[str, RigidObjectCfg] = MISSING


class SurfaceGripper(Refused, AssetBase):
    """A gripper that holds by suction."""

    missing = SURFACE_GRIPPERS


@configclass
class SurfaceGripperCfg(AssetBaseCfg):
    """A gripper that holds by suction."""

    class_type: type = SurfaceGripper
    max_grip_distance: float | None = None
    coaxial_force_limit: float | None = None
    shear_force_limit: float | None = None
    retry_interval: float | None = None

    _ranges: ClassVar[Ranges] = {
        "max_grip_distance coaxial_force_limit shear_force_limit retry_interval": NOT_NEGATIVE_OR_INF,
    }


place(__name__)
