"""The arm that tests of assets and of environments share."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from pxr import Gf, Usd, UsdGeom, UsdPhysics


def _author_arm(path: Path, drives: bool) -> Path:
    """Two links of 0.4 m on hinges about y, the shoulder at 0.5 m, fixed to the world; with drives or without."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    root = UsdGeom.Xform.Define(stage, "/Arm").GetPrim()
    stage.SetDefaultPrim(root)
    UsdPhysics.ArticulationRootAPI.Apply(root)
    for name, pos, mass in (
        ("base", (0, 0, 0.5), 2.0),
        ("upper", (0, 0, 0.5), 1.0),
        ("lower", (0.4, 0, 0.5), 0.5),
    ):
        link = UsdGeom.Xform.Define(stage, f"/Arm/{name}")
        link.AddTranslateOp().Set(Gf.Vec3d(*pos))
        UsdPhysics.RigidBodyAPI.Apply(link.GetPrim())
        api = UsdPhysics.MassAPI.Apply(link.GetPrim())
        api.CreateMassAttr(mass)
        api.CreateCenterOfMassAttr(Gf.Vec3f(0.2, 0, 0) if name != "base" else Gf.Vec3f(0, 0, 0))
        api.CreateDiagonalInertiaAttr(Gf.Vec3f(0.01, 0.02, 0.02))
        api.CreatePrincipalAxesAttr(Gf.Quatf(1, 0, 0, 0))
    fixed = UsdPhysics.FixedJoint.Define(stage, "/Arm/root_joint")
    fixed.CreateBody1Rel().SetTargets(["/Arm/base"])
    fixed.CreateLocalPos0Attr(Gf.Vec3f(0, 0, 0.5))
    for name, body0, body1, at in (
        ("shoulder", "base", "upper", (0, 0, 0)),
        ("elbow", "upper", "lower", (0.4, 0, 0)),
    ):
        joint = UsdPhysics.RevoluteJoint.Define(stage, f"/Arm/{name}")
        joint.CreateBody0Rel().SetTargets([f"/Arm/{body0}"])
        joint.CreateBody1Rel().SetTargets([f"/Arm/{body1}"])
        joint.CreateLocalPos0Attr(Gf.Vec3f(*at))
        joint.CreateAxisAttr("Y")
        joint.CreateLowerLimitAttr(-90.0)
        joint.CreateUpperLimitAttr(120.0)
        if drives:
            drive = UsdPhysics.DriveAPI.Apply(joint.GetPrim(), "angular")
            drive.CreateStiffnessAttr(30.0 * math.pi / 180.0)
            drive.CreateDampingAttr(3.0 * math.pi / 180.0)
            drive.CreateMaxForceAttr(25.0)
    stage.Save()
    return path


@pytest.fixture(scope="session")
def author_arm() -> Callable[..., Path]:
    """Writes the arm into a USD file, and returns it."""
    return _author_arm
