"""The type stubs of mujoco and USD: up to date, true of what is installed, and read by pyright."""

import json
import subprocess
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


def _check(tmp_path: Path, code: str) -> list[tuple[int, str]]:
    (tmp_path / "snippet.py").write_text(code)
    settings = {"include": ["snippet.py"], "typeCheckingMode": "standard", "pythonVersion": "3.11"}
    settings |= {"stubPath": str(TYPINGS), "extraPaths": [str(ROOT / "source")]}
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings))
    command = [sys.executable, "-m", "pyright", "--outputjson", "-p", str(tmp_path), "--pythonpath", sys.executable]
    report = json.loads(subprocess.run(command, capture_output=True, text=True, timeout=120).stdout)
    found = report["generalDiagnostics"]
    return sorted((item["range"]["start"]["line"] + 1, item["rule"]) for item in found if item["severity"] == "error")


_CODE = """
import mujoco
import numpy as np
from pxr import Usd, UsdGeom

spec = mujoco.MjSpec()
body = spec.worldbody.add_body(name="a", pos=np.zeros(3))
body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[1.0, 1.0, 1.0])
model = spec.compile()
model.body_pos[0] = 1.0
stage = Usd.Stage.CreateInMemory()
mesh = UsdGeom.Mesh.Define(stage, "/Mesh")
mesh.GetPointsAttr().Set([])
path: str = mesh.GetPrim().GetPath().pathString
model.body_poss
spec.worldbody.add_body(nam="b")
spec.geoms[0].rgbaa
mujoco.mjtGeom.mjGEOM_BOXX
mujoco.mj_stepp
stage.GetPrimAtPaht("/Mesh")
mesh.GetPointAttr()
mesh.GetPrim().GetPath().pathstring
UsdGeom.Mehs
model.nq = 3
"""


def test_pyright_reports_misspelt_names_and_nothing_else(tmp_path):
    lines = [line for line, _ in _check(tmp_path, _CODE)]
    assert lines == list(range(15, 25))


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
