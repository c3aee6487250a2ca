"""Physics materials (names of Isaac Lab's)."""

from __future__ import annotations

from typing import ClassVar, Literal

from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.ranges import NOT_NEGATIVE, POSITIVE, Range, Ranges


@configclass
class PhysicsMaterialCfg(ConfigBase):
    """Base of physics materials."""


@configclass
class RigidBodyMaterialCfg(PhysicsMaterialCfg):
    """Material of rigid bodies. MuJoCo has one sliding friction: :attr:`dynamic_friction` is used.

    The friction of a contact is the larger of the two geoms' (MuJoCo), not their average (PhysX).
    """

    static_friction: float = 0.5
    """PhysX's friction at rest. Has no effect."""
    dynamic_friction: float = 0.5
    """Sliding friction coefficient."""
    restitution: float = 0.0
    """Ignored: contacts do not bounce."""
    friction_combine_mode: Literal["average", "min", "multiply", "max"] = "average"
    """Ignored: MuJoCo takes the larger friction of two geoms."""
    restitution_combine_mode: Literal["average", "min", "multiply", "max"] = "average"
    """Ignored: contacts do not bounce."""
    compliant_contact_stiffness: float = 0.0
    """Ignored: MuJoCo's contact stiffness is per unit mass."""
    compliant_contact_damping: float = 0.0
    """Ignored: MuJoCo's contact damping is per unit mass."""

    _ranges: ClassVar[Ranges] = {
        (
            "static_friction dynamic_friction restitution compliant_contact_stiffness compliant_contact_damping"
        ): NOT_NEGATIVE,
    }


@configclass
class DeformableBodyMaterialCfg(PhysicsMaterialCfg):
    """Material of deformable bodies.

    MuJoCo integrates bodies of about 10 to 100 kPa well. The default stiffness is Isaac Lab's. With it the solver does
    not converge, and the environment is reported as failed.
    """

    density: float | None = None
    """Density in kg/m^3; None for that of water."""
    dynamic_friction: float = 0.25
    """Sliding friction coefficient."""
    youngs_modulus: float = 50000000.0
    """Young's modulus in Pa."""
    poissons_ratio: float = 0.45
    """Poisson's ratio."""
    elasticity_damping: float = 0.005
    """Damping over stiffness in s."""
    damping_scale: float = 1.0
    """PhysX's factor on the damping. Has no effect here."""

    _ranges: ClassVar[Ranges] = {
        "density dynamic_friction elasticity_damping damping_scale": NOT_NEGATIVE,
        "youngs_modulus": POSITIVE,
        "poissons_ratio": Range(-1.0, 0.5, above=True, below=True),
    }
