"""The page on robots of one's own: its arm, authored here from the URDF's text, holds its pose as the page prints."""

import math
import re
import runpy
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from page_files import write_files
from pxr import Gf, Usd, UsdGeom, UsdPhysics

PAGE = Path(__file__).resolve().parents[2] / "docs" / "own_robot.md"
GRAVITY, STIFFNESS = 9.81, 400.0


def _numbers(element, name: str) -> list[float]:
    return [float(value) for value in element.get(name).split()] if element is not None else [0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def urdf():
    (text,) = re.findall(r'^```xml title="my_arm.urdf"\n(.*?)^```$', PAGE.read_text(), flags=re.DOTALL | re.MULTILINE)
    return ElementTree.fromstring(text)


def _author(urdf, path: Path) -> None:
    """Links as bodies without shapes, joints about y, and the first link fixed to the world."""
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/arm").GetPrim())
    for link in urdf.findall("link"):
        prim = UsdGeom.Xform.Define(stage, f"/arm/{link.get('name')}").GetPrim()
        UsdPhysics.RigidBodyAPI.Apply(prim)
        mass = UsdPhysics.MassAPI.Apply(prim)
        inertia = link.find("inertial/inertia")
        mass.CreateMassAttr(float(link.find("inertial/mass").get("value")))
        mass.CreateCenterOfMassAttr(Gf.Vec3f(*_numbers(link.find("inertial/origin"), "xyz")))
        mass.CreateDiagonalInertiaAttr(Gf.Vec3f(*(float(inertia.get(key)) for key in ("ixx", "iyy", "izz"))))
    root = UsdPhysics.FixedJoint.Define(stage, "/arm/root_joint")
    root.CreateBody1Rel().SetTargets(["/arm/base"])
    UsdPhysics.ArticulationRootAPI.Apply(stage.GetPrimAtPath("/arm/base"))
    for joint in urdf.findall("joint"):
        prim = UsdPhysics.RevoluteJoint.Define(stage, f"/arm/{joint.get('name')}")
        prim.CreateBody0Rel().SetTargets([f"/arm/{joint.find('parent').get('link')}"])
        prim.CreateBody1Rel().SetTargets([f"/arm/{joint.find('child').get('link')}"])
        prim.CreateLocalPos0Attr(Gf.Vec3f(*_numbers(joint.find("origin"), "xyz")))
        prim.CreateAxisAttr("Y")
        prim.CreateLowerLimitAttr(math.degrees(float(joint.find("limit").get("lower"))))
        prim.CreateUpperLimitAttr(math.degrees(float(joint.find("limit").get("upper"))))
    stage.Save()


def _weights(urdf, angles: tuple[float, float]) -> tuple[float, float]:
    """Moments (N m) of gravity about both joints, with the links leaning by the angles (rad) and their sum."""

    def of(link: str) -> tuple[float, float]:
        inertial = urdf.find(f"link[@name='{link}']/inertial")
        return float(inertial.find("mass").get("value")), _numbers(inertial.find("origin"), "xyz")[2]

    (upper, upper_z), (hand, hand_z) = of("upper"), of("hand")
    elbow_z = _numbers(urdf.find("joint[@name='joint2']/origin"), "xyz")[2]
    second = hand * hand_z * math.sin(sum(angles)) * GRAVITY
    first = (upper * upper_z + hand * elbow_z) * math.sin(angles[0]) * GRAVITY
    return first + second, second


def test_the_arm_rests_where_its_drives_carry_its_weight(urdf, tmp_path, monkeypatch, capsys):
    write_files(PAGE, tmp_path)
    (tmp_path / "my_arm").mkdir()
    _author(urdf, tmp_path / "my_arm" / "my_arm.usda")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.chdir(tmp_path)
    try:
        runpy.run_path("hold_pose.py")
    finally:
        sys.modules.pop("my_arm", None)
    printed = [line.strip() for line in capsys.readouterr().out.splitlines()]
    assert printed == re.findall(r"^    (\d\.\d s: largest error .*)$", PAGE.read_text(), flags=re.MULTILINE)

    angles = [0.3, 0.6]  # rest, by iteration: each joint sags by moment / stiffness
    for _ in range(20):
        first, second = _weights(urdf, (angles[0], angles[1]))
        angles = [0.3 + first / STIFFNESS, 0.6 + second / STIFFNESS]
    efforts = [float(value) for value in re.findall(r"-\d+\.\d+", printed[-1])]
    assert efforts == pytest.approx([-first, -second], abs=0.006)
    assert f"largest error {first / STIFFNESS:.4f}" in printed[-1]
