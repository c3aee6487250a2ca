"""Physics properties set on spawned assets: their configs and their way into a MjSpec."""

from .schemas import apply_schemas
from .schemas_cfg import (
    ArticulationRootPropertiesCfg,
    CollisionPropertiesCfg,
    DeformableBodyPropertiesCfg,
    FixedTendonPropertiesCfg,
    JointDrivePropertiesCfg,
    MassPropertiesCfg,
    RigidBodyPropertiesCfg,
    SpatialTendonPropertiesCfg,
)

__all__ = [
    "ArticulationRootPropertiesCfg",
    "CollisionPropertiesCfg",
    "DeformableBodyPropertiesCfg",
    "FixedTendonPropertiesCfg",
    "JointDrivePropertiesCfg",
    "MassPropertiesCfg",
    "RigidBodyPropertiesCfg",
    "SpatialTendonPropertiesCfg",
    "apply_schemas",
]
