"""Configuration of a cart-pole."""

import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets.articulation import ArticulationCfg, ArticulationMirrorCfg
from lift_lab_assets.files import ASSETS_USD_DIR

CARTPOLE_CFG = ArticulationCfg(
    spawn=sim_utils.UsdFileCfg(
        usd_path=f"{ASSETS_USD_DIR}/cartpole.usda",
        articulation_props=sim_utils.ArticulationRootPropertiesCfg(enabled_self_collisions=False),
    ),
    init_state=ArticulationCfg.InitialStateCfg(
        pos=(0.0, 0.0, 2.0),
        joint_pos={"slider_to_cart": 0.0, "cart_to_pole": 0.0},
    ),
    actuators={
        "cart_actuator": ImplicitActuatorCfg(
            joint_names_expr=["slider_to_cart"],
            effort_limit_sim=400.0,
            stiffness=0.0,
            damping=10.0,
        ),
        "pole_actuator": ImplicitActuatorCfg(
            joint_names_expr=["cart_to_pole"],
            effort_limit_sim=400.0,
            stiffness=0.0,
            damping=0.0,
        ),
    },
)
"""A cart on a rail with a pole on a free hinge; every number is Isaac Lab's.

The rail is 2 m above the ground. The cart moves along y within 4 m either way. The pole turns about x without limits.
Force on the cart is commanded as a joint effort.
"""

CARTPOLE_MIRROR = ArticulationMirrorCfg(signs={"slider_to_cart": -1.0, "cart_to_pole": -1.0})
"""Mirror image in the plane y = 0, across the rail: both joints change their sign."""
