"""The Franka Emika Panda with its hand, as tables of numbers. Owns every number of
`assets/usd/franka_panda.usda`.

Units are SI and radians. Frames follow franka_description's URDF: one frame a link, placed by the joint above
it; the joint turns (or slides) along an axis of that frame. Sources:

- kinematics, ranges, speed and effort limits, collision shapes: franka_description (Apache-2.0, Copyright
  2017 Franka Emika GmbH), the URDF of the robot's maker;
- masses, centres of mass, inertia tensors and joint friction of the arm: Gaz, Cognetti, Oliva, Robuffo
  Giordano and De Luca, "Dynamic Identification of the Franka Emika Panda Robot", IEEE RA-L 2019;
- armature, damping, drive gains and the contact numbers of the finger pads: measured choices for grasping in
  MuJoCo, each explained where it stands.
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

Vec3 = tuple[float, float, float]


class Link(NamedTuple):
    """A rigid link: mass (kg), centre of mass (m) and inertia about it (kg m^2), all in the link's own
    frame."""

    mass: float
    com: Vec3
    inertia: tuple[float, float, float, float, float, float]
    """Ixx, Iyy, Izz, Ixy, Ixz, Iyz."""


class Joint(NamedTuple):
    """A joint between two links. `xyz` (m) and `rpy` (rad) place the child's frame in the parent's at q =
    0."""

    name: str
    kind: str
    """`revolute`, `prismatic` or `fixed`."""
    parent: str
    child: str
    xyz: Vec3
    rpy: Vec3 = (0.0, 0.0, 0.0)
    axis: str = "Z"
    """Axis of motion in the child's frame: `Z`, `Y` or `-Y`."""
    lower: float = 0.0
    """rad or m."""
    upper: float = 0.0
    velocity: float = 0.0
    """Speed limit, rad/s or m/s."""
    effort: float = 0.0
    """Effort limit, N m or N."""


class Capsule(NamedTuple):
    """A cylinder of `length` with a half-sphere of `radius` at each end, centred at `xyz` along `axis`
    (m)."""

    name: str
    radius: float
    length: float
    xyz: Vec3 = (0.0, 0.0, 0.0)
    axis: str = "Z"


class Box(NamedTuple):
    """A box of full edge lengths `size` centred at `xyz` (m), turned by `rpy` (rad)."""

    name: str
    size: Vec3
    xyz: Vec3
    rpy: Vec3 = (0.0, 0.0, 0.0)


class Contact(NamedTuple):
    """MuJoCo's contact numbers of a surface."""

    friction: float
    """Sliding coefficient; USD's static and dynamic friction alike."""
    torsional: float
    """Torsional coefficient, m."""
    rolling: float
    """Rolling coefficient, m."""
    condim: int
    """3: sliding friction. 4: torsional besides, so that a pinched object does not spin about the pinch
    axis."""
    solref: tuple[float, float]
    """Time constant (s) and damping ratio of the contact."""
    solimp: tuple[float, float, float]


# ------------------------------------------------------------------------------------------------------------
# Links. The arm is Gaz et al.'s identification; hand and fingers are franka_description's.

LINKS: dict[str, Link] = {
    "panda_link0": Link(
        0.629769, (-0.041018, -0.00014, 0.049974), (0.00315, 0.00388, 0.004285, 8.2904e-7, 0.00015, 8.2299e-6)
    ),
    "panda_link1": Link(
        4.970684, (0.003875, 0.002081, -0.04762), (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169)
    ),
    "panda_link2": Link(
        0.646926,
        (-0.003141, -0.02872, 0.003495),
        (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704),
    ),
    "panda_link3": Link(
        3.228604,
        (0.027518, 0.039252, -0.066502),
        (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805),
    ),
    "panda_link4": Link(
        3.587895,
        (-0.05317, 0.104419, 0.027454),
        (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641),
    ),
    "panda_link5": Link(
        1.225946,
        (-0.011953, 0.041065, -0.038437),
        (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229),
    ),
    "panda_link6": Link(
        1.666555,
        (0.060149, -0.014117, -0.010517),
        (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341),
    ),
    "panda_link7": Link(
        0.735522,
        (0.010517, -0.004252, 0.061597),
        (0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741),
    ),
    "panda_hand": Link(0.73, (-0.01, 0.0, 0.03), (0.001, 0.0025, 0.0017, 0.0, 0.0, 0.0)),
    "panda_leftfinger": Link(0.015, (0.0, 0.0, 0.0), (2.375e-6, 2.375e-6, 7.5e-7, 0.0, 0.0, 0.0)),
    "panda_rightfinger": Link(0.015, (0.0, 0.0, 0.0), (2.375e-6, 2.375e-6, 7.5e-7, 0.0, 0.0, 0.0)),
}

# ------------------------------------------------------------------------------------------------------------
# Joints. The hand sits on the flange, 0.107 m along link 7, turned by -45 degrees. The URDF's finger effort
# is 100 N; 70 N is the hand's continuous grasping force (data sheet) and what a drive that holds a grasp may
# use.

JOINTS: tuple[Joint, ...] = (
    Joint(
        "panda_joint1", "revolute", "panda_link0", "panda_link1", (0.0, 0.0, 0.333),
        lower=-2.8973, upper=2.8973, velocity=2.175, effort=87.0,
    ),
    Joint(
        "panda_joint2", "revolute", "panda_link1", "panda_link2", (0.0, 0.0, 0.0), (-pi / 2, 0.0, 0.0),
        lower=-1.7628, upper=1.7628, velocity=2.175, effort=87.0,
    ),
    Joint(
        "panda_joint3", "revolute", "panda_link2", "panda_link3", (0.0, -0.316, 0.0), (pi / 2, 0.0, 0.0),
        lower=-2.8973, upper=2.8973, velocity=2.175, effort=87.0,
    ),
    Joint(
        "panda_joint4", "revolute", "panda_link3", "panda_link4", (0.0825, 0.0, 0.0), (pi / 2, 0.0, 0.0),
        lower=-3.0718, upper=-0.0698, velocity=2.175, effort=87.0,
    ),
    Joint(
        "panda_joint5", "revolute", "panda_link4", "panda_link5", (-0.0825, 0.384, 0.0), (-pi / 2, 0.0, 0.0),
        lower=-2.8973, upper=2.8973, velocity=2.61, effort=12.0,
    ),
    Joint(
        "panda_joint6", "revolute", "panda_link5", "panda_link6", (0.0, 0.0, 0.0), (pi / 2, 0.0, 0.0),
        lower=-0.0175, upper=3.7525, velocity=2.61, effort=12.0,
    ),
    Joint(
        "panda_joint7", "revolute", "panda_link6", "panda_link7", (0.088, 0.0, 0.0), (pi / 2, 0.0, 0.0),
        lower=-2.8973, upper=2.8973, velocity=2.61, effort=12.0,
    ),
    Joint("panda_hand_joint", "fixed", "panda_link7", "panda_hand", (0.0, 0.0, 0.107), (0.0, 0.0, -pi / 4)),
    Joint(
        "panda_finger_joint1", "prismatic", "panda_hand", "panda_leftfinger", (0.0, 0.0, 0.0584), axis="Y",
        lower=0.0, upper=0.04, velocity=0.2, effort=70.0,
    ),
    Joint(
        "panda_finger_joint2", "prismatic", "panda_hand", "panda_rightfinger", (0.0, 0.0, 0.0584), axis="-Y",
        lower=0.0, upper=0.04, velocity=0.2, effort=70.0,
    ),
)  # fmt: skip

ROOT_JOINT = "root_joint"
"""The fixed joint from the world to the base."""

ARMATURE = 0.1
"""Reflected rotor inertia of every joint, kg m^2 (arm) or kg (fingers): the value in common use for this
arm."""

DAMPING = {"revolute": 0.5, "prismatic": 1.0}
"""Passive viscous damping of the joints, N m s/rad and N s/m: a little more than the arm's identified 0.04 to
0.23, and what grasping was proven with. Authored as `mjc:damping`, which is per radian."""

FRICTION_LOSS = {f"panda_joint{i}": v for i, v in enumerate((0.245, 0.152, 0.183, 0.359, 0.267, 0.166, 1.211), start=1)}
"""Identified dry friction of the arm's joints, N m. Off unless the variant `JointFriction` is `identified`:
each costs a constraint row in every step, and the real arm's controller compensates it."""

DRIVE = {"revolute": (400.0, 160.0), "prismatic": (350.0, 10.0)}
"""Stiffness and damping of the drives: N m/rad and N m s/rad for the arm, N/m and N s/m for the fingers.
Isaac Lab's PhysX numbers (80/4 and 2000/100) let the arm oscillate and the fingers tunnel through a cube in
MuJoCo; with these a scripted grasp succeeds every time. An actuator configuration overrides them."""

# ------------------------------------------------------------------------------------------------------------
# Contact surfaces.

LINK_CONTACT = Contact(1.0, 0.005, 0.0001, condim=3, solref=(0.02, 1.0), solimp=(0.9, 0.95, 0.001))
"""MuJoCo's defaults."""

PAD_CONTACT = Contact(1.0, 0.02, 0.0001, condim=4, solref=(0.01, 1.0), solimp=(0.95, 0.99, 0.001))
"""Finger pads, and whatever is to be grasped. The time constant is twice a physics step of 0.005 s, the
stiffest that holds at that step."""

# ------------------------------------------------------------------------------------------------------------
# Colliders. franka_description's capsules, with one change: link 1's reaches 0.09 m below the base plane
# there, so that a table under the robot would touch it for ever. Its lower end is covered by link 0's; here
# it stops 10 mm above.

LINK_COLLIDERS: dict[str, tuple[Capsule, ...]] = {
    "panda_link0": (Capsule("panda_link0_collision", 0.09, 0.03, (-0.075, 0.0, 0.06), "X"),),
    "panda_link1": (Capsule("panda_link1_collision", 0.09, 0.183, (0.0, 0.0, -0.1415)),),
    "panda_link2": (Capsule("panda_link2_collision", 0.09, 0.12),),
    "panda_link3": (Capsule("panda_link3_collision", 0.09, 0.15, (0.0, 0.0, -0.145)),),
    "panda_link4": (Capsule("panda_link4_collision", 0.09, 0.12),),
    "panda_link5": (
        Capsule("panda_link5_collision_upper", 0.09, 0.10, (0.0, 0.0, -0.26)),
        Capsule("panda_link5_collision_lower", 0.055, 0.14, (0.0, 0.08, -0.13)),
    ),
    "panda_link6": (Capsule("panda_link6_collision", 0.08, 0.08, (0.0, 0.0, -0.03)),),
    "panda_link7": (Capsule("panda_link7_collision", 0.07, 0.14, (0.0, 0.0, 0.01)),),
}

FILTERED_PAIRS: tuple[tuple[str, str], ...] = (
    ("panda_link0", "panda_link1"),
    ("panda_link0", "panda_link2"),
    ("panda_link1", "panda_link3"),
    ("panda_link2", "panda_link4"),
    ("panda_link3", "panda_link5"),
    ("panda_link4", "panda_link6"),
    ("panda_link5", "panda_link7"),
    ("panda_link6", "panda_hand"),
)
"""Links whose capsules overlap by design, though they are not neighbours for MuJoCo: the pairs one link apart, and the
first joint's two, since the base counts as part of the world. They never collide, even where a configuration enables
self-collision. The arm's joint limits keep the true links apart."""

HAND_COLLIDERS: dict[str, tuple[Capsule, ...]] = {
    "pads": (Capsule("panda_hand_collision", 0.035, 0.14, (0.0, 0.0, 0.03), "Y"),),
    "full": (Capsule("panda_hand_collision", 0.05, 0.15, (0.0, 0.0, 0.03), "Y"),),
}
"""By variant of `FingerColliders`. `pads`: fitted to the hand's mesh, its palm at z = 0.065 m. `full`:
franka_description's, whose safety margin of 15 mm leaves 3 mm between palm and a 4 cm cube held at its
middle."""

FINGER_COLLIDERS: dict[str, tuple[Box, ...]] = {
    "pads": (
        Box("upper", (0.021, 0.017, 0.020), (0.0, 0.017, 0.012)),
        Box("pad", (0.0175, 0.0152, 0.034), (0.0, 0.00758, 0.0365)),
    ),
    "full": (
        Box("screw_mount", (0.022, 0.015, 0.020), (0.0, 0.0185, 0.011)),
        Box("carriage_sledge", (0.022, 0.0088, 0.0038), (0.0, 0.0068, 0.0022)),
        Box("diagonal", (0.0175, 0.007, 0.0235), (0.0, 0.0159, 0.02835), (pi / 6, 0.0, 0.0)),
        Box("pad", (0.0175, 0.0152, 0.0185), (0.0, 0.00758, 0.04525)),
    ),
}
"""By variant of `FingerColliders`, for the left finger; the right finger's are turned by pi about z. `pads`:
two boxes, the lower one a single flat face from knuckle to tip, which is all that a grasp needs and half of
the contact pairs. `full`: franka_description's four. Names get the finger's name in front."""

# ------------------------------------------------------------------------------------------------------------
# Variant sets on the robot's prim; the first variant of each is selected in the file.

VARIANTS: dict[str, tuple[str, ...]] = {
    "FingerColliders": ("pads", "full"),
    "FingerMimic": ("off", "on"),
    "JointFriction": ("none", "identified"),
}
"""`FingerMimic`: `off` drives each finger on its own, as Isaac Lab's configuration does; `on` couples finger
2 to finger 1 as the real hand's spindle does (and the URDF's mimic tag says)."""
