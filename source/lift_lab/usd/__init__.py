"""USD to MuJoCo: one call turns a stage into a `mujoco.MjSpec` and a report of what was read.

The physics comes from usd-core's own UsdPhysics parser, vendor schemas (newton, physx, mjc) from tables, geometry from
UsdGeom. `docs/usd.md` states what is mapped, approximated and ignored.
"""

from lift_lab.usd.api import load
from lift_lab.usd.drives import add_initial_key
from lift_lab.usd.report import ImportReport, Note, UsdImportError

__all__ = ["ImportReport", "Note", "UsdImportError", "add_initial_key", "load"]
