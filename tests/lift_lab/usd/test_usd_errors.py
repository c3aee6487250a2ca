"""Every mistake in a stage ends in one line that names the file, the prim and the attribute."""

from __future__ import annotations

import pytest
from pxr import Gf, UsdGeom

from lift_lab.usd import UsdImportError, load

HEADER = '#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = "Z"\n)\n'
ARM = """
def Xform "Robot" (prepend apiSchemas = ["PhysicsArticulationRootAPI"])
{{
    def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI"])
    {{
        float physics:mass = {mass}
        float3 physics:diagonalInertia = (0.1, 0.1, 0.1)
        {base}
    }}
    def Xform "link" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
    {{
        def Sphere "ball" (prepend apiSchemas = ["PhysicsCollisionAPI"])
        {{
            double radius = {radius}
        }}
    }}
    def PhysicsRevoluteJoint "hinge" (prepend apiSchemas = ["PhysicsDriveAPI:angular"])
    {{
        rel physics:body0 = </Robot/base>
        rel physics:body1 = <{body1}>
        float physics:lowerLimit = {lower}
        {joint}
    }}
    {more}
}}
"""
GOOD = {
    "mass": 1, "base": "", "radius": 0.1, "body1": "/Robot/link", "lower": -10, "joint": "", "more": "",
}  # fmt: skip


def _message(tmp_path, text):
    path = tmp_path / "robot.usda"
    path.write_text(HEADER + text)
    with pytest.raises(UsdImportError) as caught:
        load(path)
    message = str(caught.value)
    assert "\n" not in message
    return message.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("change", "prim", "attribute", "reason"),
    [
        ({"body1": "/Robot/nowhere"}, "/Robot/hinge", "physics:body1", "no prim at"),
        ({"body1": "/Robot/base"}, "/Robot/hinge", "physics:body1", "both sides"),
        ({"mass": -1}, "/Robot/base", "physics:mass", "positive"),
        ({"mass": "nan"}, "/Robot/base", "physics:mass", "not a number"),
        ({"mass": "inf"}, "/Robot/base", "physics:mass", "positive"),
        ({"mass": 0}, "/Robot/base", "physics:mass", "mass"),
        ({"radius": 0}, "/Robot/link/ball", "radius", "positive"),
        ({"radius": "nan"}, "/Robot/link/ball", "radius", "not a number"),
        ({"lower": "nan"}, "/Robot/hinge", "physics:lowerLimit", "not a number"),
        ({"joint": "point3f physics:localPos0 = (0, inf, 0)"}, "/Robot/hinge", "physics:localPos0", "finite"),
        ({"joint": "float drive:angular:physics:stiffness = nan"}, "/Robot/hinge", "drive:angular", "number"),
        ({"joint": "float drive:angular:physics:damping = -2"}, "/Robot/hinge", "drive:angular", "negative"),
        ({"joint": "float physxJoint:armature = -2"}, "/Robot/hinge", "armature", "negative"),
        ({"joint": 'token physics:upperLimit = "far"'}, "/Robot/hinge", "physics:upperLimit", "text, not a number"),
        ({"base": "float3 physics:density = (1, 2, 3)"}, "/Robot/base", "physics:density", "a Vec3, not a number"),
        ({"base": "int[] physics:centerOfMass = [1]"}, "/Robot/base", "physics:centerOfMass", "array of numbers"),
        (
            {"base": 'double3 xformOp:scale = (0, 1, 1)\nuniform token[] xformOpOrder = ["xformOp:scale"]'},
            "/Robot/base", "xformOp:scale", "singular",
        ),
        (
            {"base": "matrix4d xformOp:transform = ((nan,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))"},
            "/Robot/base", "xformOp:transform", "number",
        ),
    ],
)  # fmt: skip
def test_a_bad_value_names_file_prim_and_attribute(tmp_path, change, prim, attribute, reason):
    message = _message(tmp_path, ARM.format(**{**GOOD, **change}))
    assert message.startswith(f"<{prim}>.{attribute}"), message
    assert reason in message


@pytest.mark.parametrize(
    ("text", "where"),
    [
        ('def "A" (references = @./gone.usda@</B>) {\n}\n', "<A>.references"),
        ('def "A" (references = </B>) {\n}\ndef "B" (references = </A>) {\n}\n', ".references"),
        ('def "A" {\n def "B" (payload = @./gone.usda@) {\n}\n}\n', "<A/B>.references"),
    ],
)
def test_a_missing_or_circular_reference_names_its_prim(tmp_path, text, where):
    message = _message(tmp_path, text)
    assert where.replace("<", "").replace(">", "") in message.replace("</", "").replace(">", "")


def test_layers_that_include_each_other_are_an_error_that_names_them(tmp_path):
    (tmp_path / "other.usda").write_text("#usda 1.0\n(\n    subLayers = [@./robot.usda@]\n)\n")
    path = tmp_path / "robot.usda"
    path.write_text("#usda 1.0\n(\n    subLayers = [@./other.usda@]\n)\n")
    with pytest.raises(UsdImportError, match=r"robot\.usda: .*subLayers.*"):
        load(path)


def test_a_root_joint_that_leads_to_no_world_names_itself(tmp_path):
    """An articulation root on a joint claims a base fixed to the world."""
    more = """def PhysicsFixedJoint "root" (prepend apiSchemas = ["PhysicsArticulationRootAPI"])
    {
        rel physics:body1 = </Robot/empty>
    }
    def Xform "empty" {
    }"""
    message = _message(tmp_path, ARM.format(**{**GOOD, "more": more}))
    assert message.startswith("</Robot/root>.physics:body1")
    assert "no rigid body" in message


def test_text_that_is_not_utf_8_is_refused(author, monkeypatch):
    """Damaged crates hold such names, and reading them in Python fails anywhere."""

    def read(*_):
        b"\xff".decode()

    monkeypatch.setattr("lift_lab.usd.api.parse", read)
    with pytest.raises(UsdImportError, match="not UTF-8"):
        author().load()


@pytest.mark.parametrize("kind", ["deformable", "particles", "conveyor"])
def test_what_other_engines_simulate_is_reported_and_strict_refuses_it(author, notes, kind):
    a = author()
    schema = {
        "deformable": "PhysxDeformableSurfaceAPI", "particles": "PhysxParticleSetAPI",
        "conveyor": "PhysxSurfaceVelocityAPI",
    }[kind]  # fmt: skip
    a.set(a.gprim("/Robot/thing", "Cube", collider=kind == "conveyor", size=0.2), schema)
    _, report = a.load()
    assert notes(report, "/Robot/thing")[0] == ["not simulated here"]
    with pytest.raises(UsdImportError, match=rf"</Robot/thing>\.{schema}"):
        a.load(strict=True)


def test_a_tetrahedral_mesh_is_reported(author, notes):
    a = author()
    UsdGeom.TetMesh.Define(a.stage, "/Robot/jelly").CreatePointsAttr([Gf.Vec3f(0)] * 4)
    assert "TetMesh" in notes(a.load()[1], "/Robot/jelly")[0][0]
