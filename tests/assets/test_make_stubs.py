"""The type stubs of mujoco and USD: up to date, and true of what is installed."""

import sys
from pathlib import Path

import make_stubs
import mujoco
import pytest
import stubs_of_usd
from pxr import Gf, Sdf, Tf, Usd, UsdGeom, UsdShade

ROOT = Path(__file__).resolve().parents[2]
TYPINGS = ROOT / "typings"


def _files(folder: Path) -> dict[str, str]:
    return {path.relative_to(folder).as_posix(): path.read_text() for path in folder.rglob("*") if path.is_file()}


def test_the_stubs_are_those_of_the_code_and_of_the_installed_libraries(tmp_path):
    text = (TYPINGS / "pxr-stubs" / "Usd" / "__init__.pyi").read_text().splitlines()[0]
    usd = ".".join(map(str, Usd.GetVersion()[1:]))
    if mujoco.__version__ != "4.0.0" or f"usd-core {usd}." not in text:
        pytest.skip("the stubs are of other versions than those installed")
    make_stubs.make(tmp_path)
    assert _files(tmp_path) == _files(TYPINGS)


def _matches(value: object, annotation: str) -> bool:
    names = {module: sys.modules[f"pxr.{module}"] for module in stubs_of_usd.MODULES if f"pxr.{module}" in sys.modules}
    if annotation.startswith("tuple["):
        return isinstance(value, tuple)
    if annotation.startswith("list["):
        inner = annotation[5:-1]
        return all(_matches(item, inner) for item in value)
    return any(isinstance(value, eval(part, dict(names))) for part in annotation.split(" | ") if part != "None")


def test_results_in_the_stubs_are_those_of_a_stage():
    stage = Usd.Stage.CreateInMemory()
    mesh = UsdGeom.Mesh.Define(stage, "/World/Mesh")
    mesh.AddTranslateOp().Set((1.0, 2.0, 3.0))
    mesh.GetPrim().GetVariantSets().AddVariantSet("look").AddVariant("red")
    shader = UsdShade.Shader.Define(stage, "/World/Shader")
    owners = {
        "Gf.Matrix4d": Gf.Matrix4d(1.0),
        "Gf.Quatd": Gf.Quatd(1.0),
        "Gf.Quatf": Gf.Quatf(1.0),
        "Gf.Quath": Gf.Quath(1.0),
        "Sdf.AssetPath": Sdf.AssetPath("a.usda"),
        "Sdf.Layer": stage.GetRootLayer(),
        "Sdf.Path": Sdf.Path("/World/Mesh"),
        "Tf.Type": Tf.Type.FindByName("UsdGeomMesh"),
        "Usd.Attribute": mesh.GetPointsAttr(),
        "Usd.Prim": mesh.GetPrim(),
        "Usd._Iterator": iter(Usd.PrimRange(mesh.GetPrim())),
        "Usd.Stage": stage,
        "Usd.VariantSet": mesh.GetPrim().GetVariantSet("look"),
        "Usd.VariantSets": mesh.GetPrim().GetVariantSets(),
        "UsdGeom.Imageable": UsdGeom.Imageable(mesh),
        "UsdGeom.PrimvarsAPI": UsdGeom.PrimvarsAPI(mesh),
        "UsdGeom.Xformable": UsdGeom.Xformable(mesh),
        "UsdShade.Shader": shader,
    }
    checked = 0
    for owner, value in owners.items():
        for name, annotation in stubs_of_usd.RESULTS[owner].items():
            found = getattr(value, name)
            if callable(found):
                try:
                    found = found()
                except Tf.ErrorException:
                    raise
                except Exception:  # it takes arguments
                    continue
            if found is not None and annotation != "Any":
                assert _matches(found, annotation), (owner, name, annotation, type(found))
                checked += 1
    assert checked > 50
