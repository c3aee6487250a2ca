"""A small author of stages for the importer's tests: one call per prim, numbers in the stage's own units."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from lift_lab.usd import ImportReport, load


class Author:
    """An in-memory stage with a default prim /Robot and shorthands for physics prims."""

    def __init__(self, up: str = "Z", metres: float = 1.0, kilograms: float | None = None) -> None:
        self.stage = Usd.Stage.CreateInMemory()
        UsdGeom.SetStageUpAxis(self.stage, up)
        UsdGeom.SetStageMetersPerUnit(self.stage, metres)
        if kilograms is not None:
            UsdPhysics.SetStageKilogramsPerUnit(self.stage, kilograms)
        self.stage.SetDefaultPrim(UsdGeom.Xform.Define(self.stage, "/Robot").GetPrim())

    def set(self, prim: Any, schema: str | None = None, **_: Any) -> Any:
        """Apply an API schema by name, registered or not."""
        prim = prim.GetPrim() if hasattr(prim, "GetPrim") else self.stage.GetPrimAtPath(prim)
        if schema:
            prim.AddAppliedSchema(schema)
        return prim

    def attrs(self, prim: Any, values: dict[str, Any], schema: str | None = None) -> Any:
        """Author attributes whose type is guessed from the value."""
        prim = self.set(prim, schema)
        for name, value in values.items():
            existing = prim.GetAttribute(name)
            attribute = existing if existing else prim.CreateAttribute(name, _type_of(value))
            attribute.Set(value)
        return prim

    def place(self, prim: Any, pos=None, quat=None, scale=None) -> Any:
        """Translate, orient (wxyz), scale ops."""
        xform = UsdGeom.Xformable(prim)
        if pos is not None:
            xform.AddTranslateOp().Set(Gf.Vec3d(*map(float, pos)))
        if quat is not None:
            xform.AddOrientOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Quatd(*map(float, quat)))
        if scale is not None:
            xform.AddScaleOp(UsdGeom.XformOp.PrecisionDouble).Set(Gf.Vec3d(*map(float, scale)))
        return prim

    def body(self, path: str, pos=None, quat=None, scale=None, mass=1.0, inertia=(0.01, 0.01, 0.01), com=(0, 0, 0)):
        """Rigid body with explicit mass properties; `mass=None` authors none."""
        prim = self.place(UsdGeom.Xform.Define(self.stage, path).GetPrim(), pos, quat, scale)
        UsdPhysics.RigidBodyAPI.Apply(prim)
        if mass is not None:
            self.mass(prim, mass=mass, diagonalInertia=Gf.Vec3f(*inertia), centerOfMass=Gf.Vec3f(*com))
        return prim

    def mass(self, prim: Any, **values: Any) -> Any:
        """MassAPI with the given `physics:` attributes."""
        prim = prim.GetPrim() if hasattr(prim, "GetPrim") else self.stage.GetPrimAtPath(prim)
        UsdPhysics.MassAPI.Apply(prim)
        return self.attrs(prim, {f"physics:{name}": value for name, value in values.items()})

    def gprim(self, path: str, kind: str, pos=None, quat=None, scale=None, collider=True, **attrs: Any):
        """A UsdGeom prim, a collider unless told otherwise."""
        prim = self.place(getattr(UsdGeom, kind).Define(self.stage, path).GetPrim(), pos, quat, scale)
        self.attrs(prim, attrs)
        if collider:
            UsdPhysics.CollisionAPI.Apply(prim)
        return prim

    def mesh(self, path: str, points, faces, collider=True, approximation=None, pos=None, quat=None, scale=None):
        """A mesh of polygons given as lists of vertex indices."""
        prim = self.gprim(path, "Mesh", pos, quat, scale, collider)
        mesh = UsdGeom.Mesh(prim)
        mesh.CreatePointsAttr([Gf.Vec3f(*map(float, p)) for p in points])
        mesh.CreateFaceVertexCountsAttr([len(f) for f in faces])
        mesh.CreateFaceVertexIndicesAttr([i for f in faces for i in f])
        if approximation:
            UsdPhysics.MeshCollisionAPI.Apply(prim).CreateApproximationAttr(approximation)
        return prim

    def joint(self, path: str, kind: str, body0=None, body1=None, axis=None, pos0=None, rot0=None, pos1=None,
              rot1=None, limits=None, **attrs: Any):  # fmt: skip
        """A joint prim; `limits` are the authored lower and upper limit."""
        joint = getattr(UsdPhysics, kind).Define(self.stage, path)
        for name, body in (("0", body0), ("1", body1)):
            if body:
                getattr(joint, f"CreateBody{name}Rel")().SetTargets([body])
        for name, pos, rot in (("0", pos0, rot0), ("1", pos1, rot1)):
            if pos is not None:
                getattr(joint, f"CreateLocalPos{name}Attr")(Gf.Vec3f(*map(float, pos)))
            if rot is not None:
                getattr(joint, f"CreateLocalRot{name}Attr")(Gf.Quatf(*map(float, rot)))
        if axis:
            joint.CreateAxisAttr(axis)
        if limits is not None:
            joint.CreateLowerLimitAttr(float(limits[0]))
            joint.CreateUpperLimitAttr(float(limits[1]))
        return self.attrs(joint.GetPrim(), attrs)

    def drive(self, prim: Any, token: str = "angular", **values: Any):
        """DriveAPI with the given `drive:<token>:physics:` attributes."""
        UsdPhysics.DriveAPI.Apply(prim, token)
        return self.attrs(prim, {f"drive:{token}:physics:{name}": value for name, value in values.items()})

    def material(self, path: str, **values: Any):
        """Physics material with the given `physics:` attributes."""
        from pxr import UsdShade

        material = UsdShade.Material.Define(self.stage, path)
        UsdPhysics.MaterialAPI.Apply(material.GetPrim())
        self.attrs(material.GetPrim(), {f"physics:{name}": value for name, value in values.items()})
        return material

    def bind(self, prim: Any, material: Any, purpose: str = "physics") -> None:
        """Bind a material for a purpose."""
        from pxr import UsdShade

        prim = prim.GetPrim() if hasattr(prim, "GetPrim") else self.stage.GetPrimAtPath(prim)
        UsdShade.MaterialBindingAPI.Apply(prim).Bind(material, materialPurpose=purpose)

    def load(self, **options: Any) -> tuple[mujoco.MjModel, ImportReport]:
        """Import and compile."""
        spec, report = load(self.stage, **options)
        return spec.compile(), report


def _type_of(value: Any) -> Sdf.ValueTypeName:
    names = Sdf.ValueTypeNames
    if isinstance(value, bool):
        return names.Bool
    if isinstance(value, int):
        return names.Int
    if isinstance(value, float):
        return names.Float
    if isinstance(value, str):
        return names.Token
    if isinstance(value, Gf.Vec3f):
        return names.Float3
    if isinstance(value, Gf.Quatf):
        return names.Quatf
    if isinstance(value, (list, tuple, np.ndarray)):
        return names.IntArray if all(isinstance(v, int) for v in value) else names.DoubleArray
    raise TypeError(type(value))


@pytest.fixture
def author():
    """The stage author's class."""
    return Author


@pytest.fixture
def notes():
    """Reasons of the notes about one prim: `notes(report, "/Robot/j")` -> (ignored, approximated)."""

    def of(report: ImportReport, path: str) -> tuple[list[str], list[str]]:
        return (
            [n.reason for n in report.ignored if n.prim_path == path],
            [n.reason for n in report.approximated if n.prim_path == path],
        )

    return of
