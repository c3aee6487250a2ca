"""Physics on prims that cannot have it: types and schemas that USD does not know, attributes without their schema."""

from __future__ import annotations

import difflib
import re
from functools import cache

from pxr import Tf, Usd, UsdGeom, UsdPhysics

from lift_lab.usd.newton import KIND as NEWTON_ACTUATOR
from lift_lab.usd.parse import applied_schemas, has_schema, value_of

KINDS = ("MjcActuator", "MjcTendon", "MjcKeyframe", NEWTON_ACTUATOR)
"""Vendors' types of prims that are read."""
_VENDOR = re.compile(r"^(Physx|Newton|Mjc)")
_PHYSICAL_TYPE = re.compile(r"physics|joint|rigid|colli|articulation", re.IGNORECASE)
_PHYSICAL_SCHEMA = re.compile(r"^(Physics|Physx|Newton|Mjc)")
_AXES = ("transX", "transY", "transZ", "rotX", "rotY", "rotZ")
_TOKENS: dict[str, dict[str, tuple[str, ...]]] = {
    "drive": {"revolute": ("angular",), "prismatic": ("linear",), "d6": _AXES},
    "limit": {"d6": _AXES},
}
"""Instances of DriveAPI and LimitAPI that a joint of each kind takes."""

_JOINT, _SCENE, _GROUP = "PhysicsJoint", "PhysicsScene", "PhysicsCollisionGroup"
_BODY, _COLLIDER, _MASS = "PhysicsRigidBodyAPI", "PhysicsCollisionAPI", "PhysicsMassAPI"
_MATERIAL, _ROOT = "PhysicsMaterialAPI", "PhysicsArticulationRootAPI"
_NEEDS: tuple[tuple[str, tuple[str, ...]], ...] = (
    (r"physics:(body[01]|local(Pos|Rot)[01]|(lower|upper)Limit|coneAngle\dLimit|(min|max)Distance)", (_JOINT,)),
    (r"physics:(axis|jointEnabled|excludeFromArticulation|break(Force|Torque))", (_JOINT,)),
    (r"(drive|limit|state|physxJointAxis|physxMimicJoint):.+|physxJoint:(armature|maxJointVelocity)", (_JOINT,)),
    (r"newton:(armature|friction|damping|velocityLimit)|urdf:limit:effort", (_JOINT,)),
    (r"physics:(rigidBodyEnabled|kinematicEnabled)|physxRigidBody:disableGravity", (_BODY,)),
    (r"physics:collisionEnabled", (_COLLIDER, _JOINT)),
    (r"physics:approximation", ("PhysicsMeshCollisionAPI",)),
    (r"physxCollision:(rest|contact)Offset", (_COLLIDER,)),
    (r"physics:(mass|centerOfMass|diagonalInertia|principalAxes)|newton:inertia", (_MASS,)),
    (r"physics:density", (_MASS, _MATERIAL)),
    (r"physics:((dynamic|static)Friction|restitution)|newton:(torsional|rolling)Friction", (_MATERIAL,)),
    (r"mjc:(torsional|rolling)friction", (_MATERIAL,)),
    (
        r"physics:gravity(Direction|Magnitude)|newton:(gravityEnabled|timeStepsPerSecond)|mjc:(option|flag):.+",
        (_SCENE,),
    ),
    (r"physics:(filteredGroups|invertFilteredGroups|mergeGroup)", (_GROUP,)),
    (r"physics:filteredPairs", ("PhysicsFilteredPairsAPI",)),
    (r"physxArticulation:enabledSelfCollisions|newton:selfCollisionEnabled", (_ROOT,)),
)
"""Attributes and the types or schemas that give them a meaning: one of those named is needed."""


def unknown_type(prim: Usd.Prim, physical: bool) -> str:
    """Return the reason why the type of a prim keeps its physics from being read; empty if it does not.

    Args:
        prim: The prim.
        physical: Whether it has physics attributes.
    """
    kind = str(prim.GetTypeName())
    if not kind or kind in KINDS:
        return ""
    if _VENDOR.match(kind):
        return "a vendor's prim type that is not read"
    if prim.GetPrimTypeInfo().GetSchemaTypeName():
        return ""
    if physical or _PHYSICAL_TYPE.search(kind) or any(_PHYSICAL_SCHEMA.match(s) for s in applied_schemas(prim)):
        hint = _near(kind, _types())
        return f"USD knows no prim type of this name, so that no physics of the prim itself is read{hint}"
    return ""


def unknown_schemas(prim: Usd.Prim) -> list[tuple[str, str]]:
    """API schemas on a prim whose names are misspelt: the name and why it has no effect.

    Names of vendors' schemas are not known to usd-core; what they are for is read by their attributes.
    """
    found = []
    for schema in applied_schemas(prim):
        name = schema.partition(":")[0]
        right = "" if _VENDOR.match(name) else _misspelt(name)
        if right:
            found.append((schema, f"USD knows no API schema of this name; did you mean '{right}'?"))
    return found


def missing_schema(prim: Usd.Prim, name: str) -> str:
    """Return the reason why an attribute has no effect on its prim: what the prim lacks; empty if nothing."""
    if str(prim.GetTypeName()) in KINDS:
        return ""  # actuators and tendons have attributes of joints
    needs = _needs(name)
    if needs and not any(_has(prim, need) for need in needs):
        if needs[0].endswith("API"):
            return f"{' or '.join(need for need in needs if need.endswith('API'))} is not applied to the prim"
        return f"the prim is no {needs[0]}"
    kind, _, rest = name.partition(":")
    if kind in _TOKENS:
        schema = f"Physics{kind.title()}API:{rest.partition(':')[0]}"
        return "" if schema in applied_schemas(prim) else f"{schema} is not applied to the prim"
    return ""


def unknown_tokens(prim: Usd.Prim, joint_kind: str) -> list[tuple[str, str]]:
    """Drives and limits whose names a joint of this kind does not have: attribute and reason."""
    found = []
    for schema in applied_schemas(prim):
        for what, kinds in _TOKENS.items():
            token = schema.removeprefix(f"Physics{what.title()}API:")
            known = token == schema or token in kinds.get(joint_kind, ())
            if not known and not (what == "drive" and _is_idle(prim, token)):
                found.append((f"{what}:{token}", f"a {joint_kind} joint has no {what} of this name"))
    return found


def _is_idle(prim: Usd.Prim, token: str) -> bool:
    """Whether a drive has no gains: Isaac Sim's MJCF importer writes such ones under names that no joint has."""
    return not any(value_of(prim, f"drive:{token}:physics:{gain}") for gain in ("stiffness", "damping"))


@cache
def _needs(name: str) -> tuple[str, ...]:
    return next((needs for pattern, needs in _NEEDS if re.fullmatch(pattern, name)), ())


def _has(prim: Usd.Prim, need: str) -> bool:
    if need == _JOINT:
        return prim.IsA(UsdPhysics.Joint)
    if need == _SCENE:
        return prim.IsA(UsdPhysics.Scene)
    if need == _GROUP:
        return prim.IsA(UsdPhysics.CollisionGroup)
    # Materials, which are no geometry, may state a density of their own.
    return has_schema(prim, need) or (need == _MASS and not prim.IsA(UsdGeom.Imageable))


def _near(name: str, choices: tuple[str, ...]) -> str:
    same_words = [choice for choice in choices if _words(choice) == _words(name)]
    close = same_words or difflib.get_close_matches(name, choices, n=1)
    return f"; did you mean '{close[0]}'?" if close else ""


def _words(name: str) -> list[str]:
    """The words of a name in camel case, sorted: older schemas had them in another order."""
    return sorted(re.findall(r"[A-Z][a-z]+", name))


@cache
def _misspelt(name: str) -> str:
    """The schema of UsdPhysics that a name that USD does not know is meant for; empty if there is none."""
    if Usd.SchemaRegistry.GetTypeFromSchemaTypeName(name) != Tf.Type.Unknown:
        return ""
    if f"Physics{name}" in _schemas():
        return f"Physics{name}"
    if not name.lower().startswith("phys"):
        return ""  # a schema of somebody else, as TensorPhysicsArticulationRootAPI
    return next(iter(difflib.get_close_matches(name, _schemas(), n=1, cutoff=0.85)), "")


@cache
def _types() -> tuple[str, ...]:
    registry, derived = Usd.SchemaRegistry, Tf.Type.FindByName("UsdTyped").GetAllDerivedTypes()
    return tuple(sorted(filter(None, (registry.GetConcreteSchemaTypeName(kind) for kind in derived))))


@cache
def _schemas() -> tuple[str, ...]:
    registry, derived = Usd.SchemaRegistry, Tf.Type.FindByName("UsdAPISchemaBase").GetAllDerivedTypes()
    names = filter(None, (registry.GetAPISchemaTypeName(schema) for schema in derived))
    return tuple(sorted(name for name in names if name.startswith("Physics")))
