"""Ready-made markers (names of Isaac Lab's)."""

from __future__ import annotations

import lift_lab.sim as sim_utils
from lift_lab.utils.assets import ISAAC_NUCLEUS_DIR

from ..visualization_markers import VisualizationMarkersCfg

__all__ = [
    "BLUE_ARROW_X_MARKER_CFG",
    "CONTACT_SENSOR_MARKER_CFG",
    "CUBOID_MARKER_CFG",
    "DEFORMABLE_TARGET_MARKER_CFG",
    "FRAME_MARKER_CFG",
    "GREEN_ARROW_X_MARKER_CFG",
    "POSITION_GOAL_MARKER_CFG",
    "RAY_CASTER_MARKER_CFG",
    "RED_ARROW_X_MARKER_CFG",
    "SPHERE_MARKER_CFG",
]


def _colour(red: float, green: float, blue: float) -> sim_utils.PreviewSurfaceCfg:
    return sim_utils.PreviewSurfaceCfg(diffuse_color=(red, green, blue))


def _arrow(red: float, green: float, blue: float) -> VisualizationMarkersCfg:
    arrow = sim_utils.UsdFileCfg(
        usd_path=f"{ISAAC_NUCLEUS_DIR}/Props/UIElements/arrow_x.usd",
        scale=(1.0, 0.1, 0.1),
        visual_material=_colour(red, green, blue),
    )
    return VisualizationMarkersCfg(markers={"arrow": arrow})


FRAME_MARKER_CFG = VisualizationMarkersCfg(
    markers={
        "frame": sim_utils.UsdFileCfg(
            usd_path=f"{ISAAC_NUCLEUS_DIR}/Props/UIElements/frame_prim.usd", scale=(0.5, 0.5, 0.5)
        ),
        "connecting_line": sim_utils.CylinderCfg(radius=0.002, height=1.0, visual_material=_colour(1.0, 1.0, 0.0)),
    }
)
"""A coordinate frame."""

RED_ARROW_X_MARKER_CFG = _arrow(1.0, 0.0, 0.0)
"""A red arrow along x."""
GREEN_ARROW_X_MARKER_CFG = _arrow(0.0, 1.0, 0.0)
"""A green arrow along x."""
BLUE_ARROW_X_MARKER_CFG = _arrow(0.0, 0.0, 1.0)
"""A blue arrow along x."""

CUBOID_MARKER_CFG = VisualizationMarkersCfg(
    markers={"cuboid": sim_utils.CuboidCfg(size=(0.1, 0.1, 0.1), visual_material=_colour(1.0, 0.0, 0.0))}
)
"""A red cuboid."""

SPHERE_MARKER_CFG = VisualizationMarkersCfg(
    markers={"sphere": sim_utils.SphereCfg(radius=0.05, visual_material=_colour(1.0, 0.0, 0.0))}
)
"""A red ball."""

POSITION_GOAL_MARKER_CFG = VisualizationMarkersCfg(
    markers={
        "target_far": sim_utils.SphereCfg(radius=0.01, visual_material=_colour(1.0, 0.0, 0.0)),
        "target_near": sim_utils.SphereCfg(radius=0.01, visual_material=_colour(0.0, 1.0, 0.0)),
        "target_invisible": sim_utils.SphereCfg(radius=0.01, visual_material=_colour(0.0, 0.0, 1.0), visible=False),
    }
)
"""A goal position: red when far, green when near."""

CONTACT_SENSOR_MARKER_CFG = VisualizationMarkersCfg(
    markers={
        "contact": sim_utils.SphereCfg(radius=0.02, visual_material=_colour(1.0, 0.0, 0.0)),
        "no_contact": sim_utils.SphereCfg(radius=0.02, visual_material=_colour(0.0, 1.0, 0.0), visible=False),
    }
)
"""A contact."""

RAY_CASTER_MARKER_CFG = VisualizationMarkersCfg(
    markers={"hit": sim_utils.SphereCfg(radius=0.02, visual_material=_colour(1.0, 0.0, 0.0))}
)
"""Point where a ray hits."""

DEFORMABLE_TARGET_MARKER_CFG = VisualizationMarkersCfg(
    markers={"target": sim_utils.SphereCfg(radius=0.02, visual_material=_colour(0.75, 0.75, 1.0))}
)
"""Target of a point of a deformable object."""
