"""Configurations of the Franka Emika Panda with its hand.

- :obj:`FRANKA_PANDA_CFG`: gains with which grasping is learned.
- :obj:`FRANKA_PANDA_HIGH_PD_CFG`: less damping, to follow the targets of an inverse-kinematics controller.
- :obj:`FRANKA_PANDA_MIRROR`: how the joints mirror in the plane between left and right.

Names, initial pose and actuator groups are Isaac Lab's. Some PhysX values do not carry over to MuJoCo; the docstring
lists them with the reason. Masses, limits and shapes come from the USD file (see its NOTICE for sources).
"""

import math

import lift_lab.sim as sim_utils
from lift_lab.actuators import ImplicitActuatorCfg
from lift_lab.assets.articulation import ArticulationCfg, ArticulationMirrorCfg
from lift_lab_assets.files import ASSETS_USD_DIR

FRANKA_PANDA_CFG = ArticulationCfg(
    spawn=sim_utils.UsdFileCfg(
        usd_path=f"{ASSETS_USD_DIR}/franka_panda.usda",
        activate_contact_sensors=False,
        rigid_props=sim_utils.RigidBodyPropertiesCfg(disable_gravity=True),
        articulation_props=sim_utils.ArticulationRootPropertiesCfg(enabled_self_collisions=False),
    ),
    init_state=ArticulationCfg.InitialStateCfg(
        joint_pos={
            "panda_joint1": 0.0,
            "panda_joint2": -0.569,
            "panda_joint3": 0.0,
            "panda_joint4": -2.810,
            "panda_joint5": 0.0,
            "panda_joint6": 3.037,
            "panda_joint7": 0.741,
            "panda_finger_joint.*": 0.04,
        },
    ),
    actuators={
        "panda_shoulder": ImplicitActuatorCfg(
            joint_names_expr=["panda_joint[1-4]"],
            effort_limit_sim=87.0,
            stiffness=400.0,
            damping=160.0,
        ),
        "panda_forearm": ImplicitActuatorCfg(
            joint_names_expr=["panda_joint[5-7]"],
            effort_limit_sim=12.0,
            stiffness=400.0,
            damping=160.0,
        ),
        "panda_hand": ImplicitActuatorCfg(
            joint_names_expr=["panda_finger_joint.*"],
            effort_limit_sim=70.0,
            stiffness=350.0,
            damping=10.0,
        ),
    },
    soft_joint_pos_limit_factor=1.0,
)
"""Panda with gains that grasp and learn.

- Initial pose (rad; fingers in m, open): Isaac Lab's.
- Arm, 400 N m/rad and 160 N m s/rad: with Isaac Lab's 80 and 4 the damping ratio is about 0.2 here, so the arm
  oscillates. A fast arm also knocks the cube off the table during exploration, and grasping is not learned.
- Fingers, 350 N/m and 10 N s/m: with Isaac Lab's 2000 and 100 a contact that is resolved at 5 ms cannot hold a light
  cube. Slower fingers never close while the policy's gripper command still changes often.
- Effort: 87 and 12 N m are the arm's data sheet, as in Isaac Lab; 70 N is the hand's continuous grasping
  force (Isaac Lab allows 200 N).
- Gravity is compensated on all links, as the real arm's controller does; Isaac Lab leaves gravity on here.
- Self-collision is off (Isaac Lab: on). The task's workspace keeps the links apart, and every tested pair of links
  costs time.
- Speed limits (2.175 and 2.61 rad/s, 0.2 m/s) are in the USD file and in ``data.joint_vel_limits``; the
  engine does not clamp to them.
"""


FRANKA_PANDA_HIGH_PD_CFG = FRANKA_PANDA_CFG.copy()
"""Panda for task-space control, for instance with differential inverse kinematics.

The shoulder and forearm have Isaac Lab's gains, 400 N m/rad and 80 N m s/rad. The arm follows a moving joint target
with a lag of damping / stiffness: 0.2 s instead of the 0.4 s of :obj:`FRANKA_PANDA_CFG`.
"""
FRANKA_PANDA_HIGH_PD_CFG.actuators["panda_shoulder"].damping = 80.0
FRANKA_PANDA_HIGH_PD_CFG.actuators["panda_forearm"].damping = 80.0

FRANKA_PANDA_MIRROR = ArticulationMirrorCfg(
    signs={"panda_joint[1357]": -1.0, "panda_joint[246]": 1.0, "panda_finger_joint.*": 1.0},
    swaps={"finger_joint1": "finger_joint2", "leftfinger": "rightfinger"},
    offsets={"panda_joint7": math.pi / 2},
)
"""Mirror image of the Panda in its plane y = 0.

The hand is mounted at 45 degrees to the flange. So joint 7 has an offset: its image is pi/2 - q. The fingers change
places.
"""
