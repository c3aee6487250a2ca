"""Notes on settings of a material that have no effect on a spawned shape."""

from __future__ import annotations

from ...ignored import note_changed_fields
from .physics_materials_cfg import RigidBodyMaterialCfg

_IGNORED = {
    "restitution": "contacts do not bounce",
    "friction_combine_mode": "MuJoCo takes the larger friction of two geoms",
    "restitution_combine_mode": "contacts do not bounce",
    "compliant_contact_stiffness": "contact stiffness in N/m has no counterpart; MuJoCo's is per unit mass",
    "compliant_contact_damping": "contact stiffness in N/m has no counterpart; MuJoCo's is per unit mass",
}


def note_ignored_material(prim_path: str, material: RigidBodyMaterialCfg) -> None:
    """Note the settings that were changed and have no effect.

    Args:
        prim_path: of the shape.
        material: its material.
    """
    note_changed_fields(f"spawn of {prim_path}: physics_material", material, _IGNORED)
