"""Checks on everything that is authored: numbers that are not, and physics that nothing here reads."""

from __future__ import annotations

import fnmatch
import re
from functools import cache

import numpy as np
from pxr import Usd

from lift_lab.usd.parse import ParsedStage
from lift_lab.usd.report import UsdImportError

_PHYSICS = re.compile(r"^(physics|drive|limit|state|newton|mjc|physx\w*)(:|$)")
_CHECKED = re.compile(
    r"^(physics|drive|limit|state|newton|mjc|physx\w*|xformOp)(:|$)"
    r"|^(points|radius\w*|height|size|width|length|positions|orientations|scales)$"
)

_READ_ATTRIBUTES = """
physics:body0 physics:body1 physics:localPos0 physics:localPos1 physics:localRot0 physics:localRot1 physics:axis
physics:lowerLimit physics:upperLimit physics:coneAngle?Limit physics:minDistance physics:maxDistance
physics:jointEnabled physics:collisionEnabled physics:excludeFromArticulation physics:breakForce
physics:breakTorque physics:rigidBodyEnabled physics:kinematicEnabled physics:mass physics:density
physics:centerOfMass physics:diagonalInertia physics:principalAxes physics:approximation physics:dynamicFriction
physics:staticFriction physics:restitution physics:gravityDirection physics:gravityMagnitude
physics:filteredPairs physics:filteredGroups physics:invertFilteredGroups physics:mergeGroup
drive:*:physics:type drive:*:physics:stiffness drive:*:physics:damping drive:*:physics:maxForce
drive:*:physics:targetPosition drive:*:physics:targetVelocity limit:*:physics:low limit:*:physics:high
state:*:physics:position newton:armature newton:damping newton:friction newton:velocityLimit newton:mimic*
newton:inertia newton:contactMargin newton:contactGap newton:maxHullVertices newton:torsionalFriction
newton:rollingFriction newton:selfCollisionEnabled newton:gravityEnabled newton:*:position newton:massModel
newton:shellThickness physxJoint:armature physxJoint:maxJointVelocity physxJointAxis:*:armature
physxJointAxis:*:maxJointVelocity physxJointAxis:*:dynamicFrictionEffort
physxJointAxis:*:viscousFrictionCoefficient physxMimicJoint:*:gearing physxMimicJoint:*:offset
physxMimicJoint:*:referenceJoint physxMimicJoint:*:referenceJointAxis physxRigidBody:disableGravity
physxCollision:contactOffset physxCollision:restOffset physxConvexHullCollision:hullVertexLimit
physxArticulation:enabledSelfCollisions mjc:option:* mjc:flag:* mjc:compiler:angle mjc:armature mjc:damping
mjc:frictionloss mjc:stiffness mjc:margin mjc:gap mjc:ref mjc:springref mjc:springdamper mjc:sol*
mjc:actuatorfrcrange:* mjc:actuatorfrclimited mjc:actuatorgravcomp mjc:group mjc:condim mjc:priority
mjc:friction mjc:contype mjc:conaffinity mjc:shellinertia mjc:maxhullvert mjc:inertia mjc:torsionalfriction
mjc:rollingfriction mjc:gravcomp mjc:coef? mjc:target mjc:torqueScale mjc:actDim mjc:actEarly mjc:*Range:*
mjc:*Limited mjc:gainPrm mjc:gainType mjc:biasPrm mjc:biasType mjc:dynPrm mjc:dynType mjc:gear mjc:inheritRange
mjc:jointInParent mjc:crankLength mjc:refSite mjc:sliderSite mjc:path* mjc:sideSites* mjc:range:* mjc:limited
mjc:springlength mjc:type mjc:width mjc:rgba mjc:qpos mjc:qvel mjc:ctrl mjc:act mjc:mpos mjc:mquat
"""
_READ = tuple(_READ_ATTRIBUTES.split())

_TUNING = {
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
    "physxSDF*": "setting of PhysX's mesh cooking",
    "physxMimicJoint:*:naturalFrequency": "MuJoCo's equality keeps its own compliance",
    "physxMimicJoint:*:dampingRatio": "MuJoCo's equality keeps its own compliance",
    "physxJoint:enableProjection": "setting of PhysX's solver",
    "physics:simulationOwner": "one scene per model",
    "physics:startsAsleep": "bodies start awake",
    "newton:sdf*": "setting of newton's solvers",
    "newton:maxSolverIterations": "setting of newton's solvers",
    "newton:timeStepsPerSecond": "the time step is the simulation's choice",
    "newton:xpbd:*": "setting of newton's solvers",
    "newton:vbd:*": "setting of newton's solvers",
    "newton:kamino:*": "setting of newton's solvers",
    "newton:jointsAddMobility": "joints between the same two bodies always add up",
    "mjc:compiler:*": "the model is compiled with explicit inertials and radians",
    "mjc:option:apirate": "not part of this MuJoCo",
}
_IGNORED = {
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


def reject_nan(stage: Usd.Stage, source: str) -> None:
    """Raise on any physical or geometric attribute that holds NaN, before usd-core's parser sees it."""
    for prim in Usd.PrimRange(stage.GetPseudoRoot(), Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
        for attribute in prim.GetAuthoredAttributes():
            name = attribute.GetName()
            if not _CHECKED.match(name):
                continue
            value = attribute.Get()
            if isinstance(value, (str, bool, int)) or value is None:
                continue
            if _has_nan(value):
                raise UsdImportError(source, str(prim.GetPath()), name, "not a number")


def _has_nan(value: object) -> bool:
    if hasattr(value, "GetReal"):
        value = (value.GetReal(), *value.GetImaginary())  # type: ignore[union-attr]
    array = np.array(value)
    if array.dtype == object:
        return any(_has_nan(item) for item in value)  # type: ignore[union-attr]
    return array.dtype.kind == "f" and bool(np.isnan(array).any())


def audit_support(parsed: ParsedStage) -> None:
    """Report every authored physics property that the importer does not read."""
    for prim in parsed.prims:
        for prop in prim.GetAuthoredProperties():
            name = prop.GetName()
            if not _PHYSICS.match(name) or _is_read(name):
                continue
            reason, tuning = _reason(name)
            parsed.report.ignore(prim.GetPath(), name, reason, tuning)
        kind = str(prim.GetTypeName())
        if re.match(r"^(Physx|Newton|Mjc)", kind) and kind not in ("MjcActuator", "MjcTendon", "MjcKeyframe"):
            parsed.report.ignore(prim.GetPath(), kind, "a vendor's prim type that is not read")
    for joint in parsed.joints.values():
        if joint.kind == "custom":
            parsed.report.ignore(joint.path, "", "a joint of a vendor's type")


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
