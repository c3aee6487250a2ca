"""Vendor schemas as data: the attributes of each dialect with their units and their values for "unset".

One table per kind of prim. The rows of a quantity are in order of precedence: mjc, newton, physx. The first authored
value that is not its sentinel wins, and the report counts its dialect. usd-core does not know these schemas, so it does
not know their fallback values. An attribute that is not authored leaves MuJoCo's default.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from pxr import Usd

from lift_lab.usd.parse import ParsedStage, value_of


@dataclass(frozen=True)
class Source:
    """One attribute that can supply a quantity; `{axis}` stands for the degree of freedom's token."""

    dialect: str
    attribute: str
    unit: str = "si"
    unset: tuple[float, ...] = (-math.inf,)


def _rows(*rows: tuple) -> tuple[Source, ...]:
    return tuple(Source(*row) for row in rows)


_INF = (math.inf, -math.inf)

JOINT = {
    "armature": _rows(
        ("mjc", "mjc:armature"),
        ("newton", "newton:armature", "inertia"),
        ("physx", "physxJointAxis:{axis}:armature", "inertia"),
        ("physx", "physxJoint:armature", "inertia"),
    ),
    "frictionloss": _rows(
        ("mjc", "mjc:frictionloss"),
        ("newton", "newton:friction", "effort"),
        ("physx", "physxJointAxis:{axis}:dynamicFrictionEffort", "effort"),
    ),
    "damping": _rows(
        ("mjc", "mjc:damping"),
        ("newton", "newton:damping", "gain"),
        ("physx", "physxJointAxis:{axis}:viscousFrictionCoefficient", "gain"),
    ),
    "velocity limit": _rows(
        ("newton", "newton:velocityLimit", "velocity", _INF),
        ("physx", "physxJointAxis:{axis}:maxJointVelocity", "velocity", _INF),
        ("physx", "physxJoint:maxJointVelocity", "velocity", _INF),
    ),
    "joint position": _rows(
        ("physx", "state:{axis}:physics:position", "position"),
        ("newton", "newton:{axis}:position", "position"),
    ),
    "stiffness": _rows(("mjc", "mjc:stiffness")),
    "margin": _rows(("mjc", "mjc:margin")),
}

COLLIDER = {
    "margin": _rows(
        ("mjc", "mjc:margin"),
        ("newton", "newton:contactMargin", "length"),
        ("physx", "physxCollision:restOffset", "length"),
    ),
    "gap": _rows(("mjc", "mjc:gap"), ("newton", "newton:contactGap", "length")),
    "condim": _rows(("mjc", "mjc:condim")),
    "priority": _rows(("mjc", "mjc:priority")),
    "solmix": _rows(("mjc", "mjc:solmix")),
    "solref": _rows(("mjc", "mjc:solref")),
    "solimp": _rows(("mjc", "mjc:solimp")),
    "friction": _rows(("mjc", "mjc:friction")),
    "group": _rows(("mjc", "mjc:group")),
    "contype": _rows(("mjc", "mjc:contype")),
    "conaffinity": _rows(("mjc", "mjc:conaffinity")),
    "hull vertices": _rows(
        ("mjc", "mjc:maxhullvert", "si", (-1,)),
        ("newton", "newton:maxHullVertices", "si", (-1,)),
        ("physx", "physxConvexHullCollision:hullVertexLimit"),
    ),
}

MATERIAL = {
    "torsional friction": _rows(
        ("mjc", "mjc:torsionalfriction"),
        ("newton", "newton:torsionalFriction", "length"),
    ),
    "rolling friction": _rows(
        ("mjc", "mjc:rollingfriction"),
        ("newton", "newton:rollingFriction", "length"),
    ),
}

BODY = {
    "gravcomp": _rows(
        ("mjc", "mjc:body:gravcomp"),
        ("mjc", "mjc:gravcomp"),
        ("physx", "physxRigidBody:disableGravity"),
    ),
}

ARTICULATION = {
    "self-collision": _rows(
        ("newton", "newton:selfCollisionEnabled"),
        ("physx", "physxArticulation:enabledSelfCollisions"),
    ),
}

SCENE = {
    "gravity switch": _rows(("mjc", "mjc:flag:gravity"), ("newton", "newton:gravityEnabled")),
    "step rate": _rows(
        ("newton", "newton:timeStepsPerSecond"),
        ("physx", "physxScene:timeStepsPerSecond"),
    ),
    "total mass": _rows(("mjc", "mjc:compiler:setTotalMass", "si", (-1,))),
}

INERTIA_6 = "newton:inertia"
"""Full inertia tensor [xx, yy, zz, xy, xz, yz] of a body in its frame, double precision."""

SITE_SCHEMAS = ("MjcSiteAPI", "NewtonSiteAPI")


TABLES = (JOINT, COLLIDER, MATERIAL, BODY, ARTICULATION, SCENE)


def patterns(*tables: dict[str, tuple[Source, ...]]) -> list[str]:
    """Every attribute of the given tables, or of all, with `*` for the axis."""
    tables = tables or TABLES
    return [source.attribute.replace("{axis}", "*") for table in tables for rows in table.values() for source in rows]


def resolve(
    parsed: ParsedStage,
    table: dict[str, tuple[Source, ...]],
    quantity: str,
    prim: Usd.Prim,
    axes: tuple[str, ...] = (),
    angular: bool = False,
) -> Any:
    """First authored value of `quantity` on `prim`, in SI units and radians, or None.

    Args:
        axes: Tokens to try for `{axis}`, as ("angular", "rotX").
        angular: Whether the degree of freedom turns; decides per-degree units.

    Raises:
        UsdImportError: The value is not a number.
    """
    for source in table[quantity]:
        names = [source.attribute.format(axis=axis) for axis in axes] if "{axis}" in source.attribute else None
        for name in names if names is not None else [source.attribute]:
            value = value_of(prim, name)
            if value is None or (np.isscalar(value) and value in source.unset):
                continue
            if isinstance(value, (bool, str)):
                parsed.report.took(quantity, source.dialect)
                return value
            array = np.asarray(value, dtype=float) * parsed.units.factor(source.unit, angular)
            if np.isnan(array).any():
                raise parsed.fail(prim, name, "not a number")
            parsed.report.took(quantity, source.dialect)
            return float(array) if array.ndim == 0 else array
    return None
