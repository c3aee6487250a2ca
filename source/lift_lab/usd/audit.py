"""Checks on everything that is authored: numbers that are not, and physics that nothing here reads."""

from __future__ import annotations

import fnmatch
import math
import re
from functools import cache
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd

from lift_lab.usd import dialects
from lift_lab.usd.deformable import BODY_SCHEMA, MATERIAL_SCHEMA
from lift_lab.usd.misplaced import missing_schema, unknown_schemas, unknown_tokens, unknown_type
from lift_lab.usd.parse import ParsedStage, applied_schemas, value_of
from lift_lab.usd.report import UsdImportError
from lift_lab.usd.stage import has_time_samples

_PHYSICS = re.compile(r"^(physics|drive|limit|state|newton|mjc|urdf|physx\w*)(:|$)")
_CHECKED = re.compile(
    r"^(physics|drive|limit|state|newton|mjc|urdf|physx\w*|xformOp)(:|$)"
    r"|^(points|radius\w*|height|size|width|length|positions|orientations|scales)$"
)
_FINITE = re.compile(
    r"^(xformOp:.*|physics:(localPos|localRot|principalAxes|diagonalInertia|gravityDirection).*)$"
    r"|^(points|positions|orientations|scales)$"
)

_READ_ELSEWHERE = """
physics:body0 physics:body1 physics:localPos0 physics:localPos1 physics:localRot0 physics:localRot1 physics:axis
physics:lowerLimit physics:upperLimit physics:coneAngle?Limit physics:minDistance physics:maxDistance
physics:jointEnabled physics:collisionEnabled physics:excludeFromArticulation physics:breakForce physics:breakTorque
physics:rigidBodyEnabled physics:kinematicEnabled physics:mass physics:density physics:centerOfMass
physics:diagonalInertia physics:principalAxes physics:approximation physics:dynamicFriction physics:staticFriction
physics:restitution physics:gravityDirection physics:gravityMagnitude physics:filteredPairs physics:filteredGroups
physics:invertFilteredGroups physics:mergeGroup drive:*:physics:type drive:*:physics:stiffness
drive:*:physics:damping drive:*:physics:maxForce drive:*:physics:targetPosition drive:*:physics:targetVelocity
limit:*:physics:low limit:*:physics:high newton:mimic* newton:inertia newton:massModel newton:shellThickness
physxMimicJoint:*:gearing physxMimicJoint:*:offset physxMimicJoint:*:referenceJoint
physxMimicJoint:*:referenceJointAxis physxCollision:contactOffset mjc:option:* mjc:flag:* mjc:compiler:angle mjc:ref
mjc:springref mjc:springdamper mjc:sol* mjc:actuatorfrcrange:* mjc:actuatorfrclimited mjc:actuatorgravcomp
mjc:shellinertia mjc:inertia mjc:coef? mjc:target mjc:torqueScale mjc:actDim mjc:actEarly mjc:*Range:* mjc:*Limited
mjc:gainPrm mjc:gainType mjc:biasPrm mjc:biasType mjc:dynPrm mjc:dynType mjc:gear mjc:inheritRange mjc:jointInParent
mjc:crankLength mjc:refSite mjc:sliderSite mjc:path* mjc:sideSites* mjc:range:* mjc:limited mjc:springlength
mjc:type mjc:width mjc:rgba mjc:qpos mjc:qvel mjc:ctrl mjc:act mjc:mpos mjc:mquat
physxDeformableBodyMaterial:youngsModulus physxDeformableBodyMaterial:poissonsRatio
physxDeformableBodyMaterial:elasticityDamping physxDeformableBodyMaterial:dynamicFriction
physxDeformableBodyMaterial:density newton:targets newton:kp newton:kd newton:ki newton:constEffort newton:delaySteps
urdf:limit:effort newton:maxEffort newton:maxMotorEffort newton:saturationEffort newton:lookup* newton:modelPath
"""
"""Attributes that other modules read by name; those of the dialects' tables come on top."""
_READ = (*_READ_ELSEWHERE.split(), *dialects.patterns())

_TUNING = {
    "urdf:calibration:*": "a number for a robot's own controller",
    "urdf:safety_controller:*": "a number for a robot's own controller",
    "physxScene:*": "setting of PhysX's solver",
    "physxArticulation:s*": "setting of PhysX's solver",
    "physxArticulation:articulationEnabled": "setting of PhysX's solver",
    "physxRigidBody:solve*": "setting of PhysX's solver",
    "physxRigidBody:s*Threshold": "setting of PhysX's solver",
    "physxRigidBody:max*": "clamp of PhysX's solver",
    "physxRigidBody:enable*": "setting of PhysX's solver",
    "physxRigidBody:retainAccelerations": "setting of PhysX's solver",
    "physxRigidBody:contactSlopCoefficient": "setting of PhysX's solver",
    "physxRigidBody:cfmScale": "setting of PhysX's solver",
    "physxRigidBody:locked*": "setting of PhysX's solver",
    "physxConvex*": "setting of PhysX's mesh cooking",
    "physxTriangleMesh*": "setting of PhysX's mesh cooking",
    "physxDeformable:*": "a soft body is one cell of eight nodes, and MuJoCo's solver its solver",
    "physxDeformableBodyMaterial:*": "setting of PhysX's solver",
    "physxSDF*": "setting of PhysX's mesh cooking",
    "physxMimicJoint:*:naturalFrequency": "MuJoCo's equality keeps its own compliance",
    "physxMimicJoint:*:dampingRatio": "MuJoCo's equality keeps its own compliance",
    "physxJoint:enableProjection": "setting of PhysX's solver",
    "physics:simulationOwner": "one scene per model",
    "physics:startsAsleep": "bodies start awake",
    "physics:tensor:*": "left over from a running simulation",
    "physics:engine": "left over from a running simulation",
    "physics:newton:*": "left over from a running simulation",
    "state:*:physics:appliedForce": "left over from a running simulation",
    "newton:sdf*": "setting of newton's solvers",
    "newton:contactStiffness": "contacts are as stiff as MuJoCo's solver makes them",
    "newton:contactDamping": "contacts are as stiff as MuJoCo's solver makes them",
    "newton:maxSolverIterations": "setting of newton's solvers",
    "newton:xpbd:*": "setting of newton's solvers",
    "newton:vbd:*": "setting of newton's solvers",
    "newton:kamino:*": "setting of newton's solvers",
    "newton:jointsAddMobility": "joints between the same two bodies always add up",
    "mjc:compiler:*": "the model is compiled with explicit inertials and radians",
    "mjc:option:apirate": "not part of this MuJoCo",
}
_IGNORED = {
    "newton:mpm:*": "no particles here",
    "newton:integralMax": "PD actuators have no integral",
    "physxTendon:*": "PhysX tendons are not read; MjcTendon is",
    "physics:velocity": "initial velocities are zero",
    "physics:angularVelocity": "initial velocities are zero",
    "state:*:physics:velocity": "initial velocities are zero",
    "newton:*:velocity": "initial velocities are zero",
    "physxJoint:jointFriction": "a coefficient times the joint's load, not a torque",
    "physxJointAxis:*:staticFrictionEffort": "dry friction has one effort, the dynamic one",
    "physxLimit:*": "limits are as stiff as MuJoCo's solver makes them",
    "newton:limit*": "limits are as stiff as MuJoCo's solver makes them",
    "physxRigidBody:linearDamping": "bodies have no damping of their own",
    "physxRigidBody:angularDamping": "bodies have no damping of their own",
    "physxRigidBody:*": "no counterpart in MuJoCo",
    "physxMaterial:*CombineMode": "MuJoCo takes the larger friction of two geoms",
    "physxMaterial:*": "contact stiffness in N/m has no counterpart; MuJoCo's is per unit mass",
    "newton:contact*": "contact stiffness in N/m has no counterpart; MuJoCo's is per unit mass",
    "physxCollision:*": "no counterpart in MuJoCo",
}

_OTHER_BODIES = re.compile(r"Deformable|Particle|Cloth|Vehicle|Character|Force|SurfaceVelocity|Trigger")
"""Schemas of things that are simulated by other engines only; soft bodies are :mod:`lift_lab.usd.deformable`'s."""


def reject_nan(stage: Usd.Stage, source: str) -> None:
    """Raise on physical or geometric attributes that hold no numbers, or values of another kind than theirs, before
    usd-core's parser sees them.

    Infinity means "no limit" or "unset" in many places; frames, points and inertia must be finite.
    """
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        for attribute in prim.GetAuthoredAttributes():
            name = attribute.GetName()
            if not _is_checked(name):
                continue
            value = attribute.Get()
            if value is None:
                continue
            expected, found = _kind_of_type(str(attribute.GetTypeName())), _kind(type(value))
            if expected not in (found, ""):
                raise UsdImportError(source, str(prim.GetPath()), name, f"holds {found}, not {expected}")
            if isinstance(value, (str, bool, int)):
                continue
            if isinstance(value, float) and math.isfinite(value):
                continue
            if isinstance(value, Sdf.UnregisteredValue):
                raise UsdImportError(source, str(prim.GetPath()), name, "of a type that USD does not know")
            numbers = _numbers(value)
            if np.isnan(numbers).any():
                raise UsdImportError(source, str(prim.GetPath()), name, "not a number")
            if _FINITE.match(name) and np.isinf(numbers).any():
                raise UsdImportError(source, str(prim.GetPath()), name, "not finite")


@cache
def _kind_of_type(name: str) -> str:
    """Kind of the values of a type name, empty for types that USD does not know."""
    kind = Sdf.ValueTypeNames.Find(name)
    return _kind(type(kind.defaultValue)) if kind and kind.defaultValue is not None else ""


@cache
def _kind(cls: type) -> str:
    """What the values of a class are, whatever their precision."""
    if issubclass(cls, (str, Sdf.AssetPath)):
        return "text"
    if issubclass(cls, (bool, int, float, Sdf.TimeCode)):
        return "a number"
    name = cls.__name__
    item = re.sub(r"(?<=\d)[fdhi]$|(?<=Quat)[fdh]$", "", name.removesuffix("Array"))
    item = {"Token": "text", "String": "text", "AssetPath": "text"}.get(item, item)
    if not name.endswith("Array"):
        return f"a {item}"
    return f"an array of {item if re.search(r'text|Quat|Vec|Matrix', item) else 'numbers'}"


@cache
def _is_checked(name: str) -> bool:
    return _CHECKED.match(name) is not None


def _numbers(value: Any) -> np.ndarray:
    """All floating-point numbers of an attribute value, flat; empty for other types."""
    if hasattr(value, "GetReal"):
        value = (value.GetReal(), *value.GetImaginary())
    array = np.array(value)
    if array.dtype == object:
        parts = [_numbers(item) for item in value]
        return np.concatenate(parts) if parts else np.empty(0)
    return array.ravel() if array.dtype.kind == "f" else np.empty(0)


def audit_support(parsed: ParsedStage) -> None:
    """Report every authored physics property that the importer does not read, or that has no effect where it is."""
    animated = has_time_samples(parsed.stage)
    for prim in parsed.prims:
        path = prim.GetPath()
        properties = prim.GetAuthoredProperties()
        kind = unknown_type(prim, any(_PHYSICS.match(prop.GetName()) for prop in properties))
        if kind:
            parsed.report.ignore(path, str(prim.GetTypeName()), kind)
        for schema, reason in unknown_schemas(prim):
            parsed.report.ignore(path, schema, reason)
        for prop in properties:
            _audit_property(parsed, prim, prop, animated, bool(kind))
        for schema in applied_schemas(prim):
            if _OTHER_BODIES.search(schema) and schema not in (BODY_SCHEMA, MATERIAL_SCHEMA):
                parsed.report.ignore(path, schema, "not simulated here")
    for joint in parsed.joints.values():
        if joint.kind == "custom":
            parsed.report.ignore(joint.path, "", "a joint of a vendor's type")
        for name, reason in unknown_tokens(joint.prim, joint.kind):
            parsed.report.ignore(joint.path, name, reason)


def _audit_property(parsed: ParsedStage, prim: Usd.Prim, prop: Usd.Property, animated: bool, covered: bool) -> None:
    """Report one property; `covered` if the prim's type, which keeps its physics from being read, is reported."""
    report, path, name = parsed.report, prim.GetPath(), prop.GetName()
    inherited = parsed.inherited.get(str(path))
    if inherited and name in inherited.attributes:
        return  # what there is to say about it is said of the prim that authors it
    if animated and _is_checked(name) and _is_animated(prop):
        report.approximate(path, name, "animated: the value at the start is taken throughout")
    if covered or not _PHYSICS.match(name):
        return
    if _is_read(name):
        missing = missing_schema(prim, name)
        if missing:
            report.ignore(path, name, missing)
    elif not _is_zero(prim, name):
        report.ignore(path, name, *_reason(name))


def _is_animated(prop: Usd.Property) -> bool:
    return any(spec.layer.ListTimeSamplesForPath(spec.path) for spec in prop.GetPropertyStack())


def _is_zero(prim: Usd.Prim, name: str) -> bool:
    """Whether a known but ignored quantity is zero, so that nothing is lost."""
    value = value_of(prim, name) if _is_ignored(name) else None
    return isinstance(value, (float, int, Gf.Vec3f)) and not isinstance(value, bool) and not np.any(np.array(value))


@cache
def _is_ignored(name: str) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in _IGNORED)


@cache
def _is_read(name: str) -> bool:
    return any(fnmatch.fnmatchcase(name, pattern) for pattern in _READ)


@cache
def _reason(name: str) -> tuple[str, bool]:
    for pattern, reason in _TUNING.items():
        if fnmatch.fnmatchcase(name, pattern):
            return reason, True
    for pattern, reason in _IGNORED.items():
        if fnmatch.fnmatchcase(name, pattern):
            return reason, False
    return "not known to this importer", False


def raise_on_ignored(parsed: ParsedStage) -> None:
    """Turn the first ignored physical note into an error (`strict=True`)."""
    for note in parsed.report.ignored:
        if not note.tuning:
            raise parsed.fail(note.prim_path, note.attribute, f"ignored: {note.reason}")
