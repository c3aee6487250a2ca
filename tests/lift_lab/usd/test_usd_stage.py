"""Opening stages: formats, composition, variants, instancers, errors and the report."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics, UsdUtils
from rich.console import Console

from lift_lab.usd import UsdImportError, load
from lift_lab.utils.errors import LiftLabError


def _ball(author, radius=0.1):
    a = author()
    a.body("/Robot/ball", pos=(0, 0, 1))
    a.gprim("/Robot/ball/c", "Sphere", radius=radius)
    return a


@pytest.mark.parametrize("suffix", ["usd", "usda", "usdc", "usdz"])
def test_every_file_format_gives_the_same_model(author, tmp_path, suffix):
    a = _ball(author)
    path = tmp_path / f"ball.{'usdc' if suffix == 'usdz' else suffix}"
    a.stage.GetRootLayer().Export(str(path))
    if suffix == "usdz":
        path = tmp_path / "ball.usdz"
        assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(tmp_path / "ball.usdc")), str(path))
    spec, report = load(path)
    assert report.path == str(path)
    assert (report.default_prim, report.bodies) == ("Robot", ["ball"])
    assert spec.compile().geom("c").size[0] == pytest.approx(0.1)


def test_references_and_payloads_are_followed(author, tmp_path):
    a = _ball(author)
    a.stage.GetRootLayer().Export(str(tmp_path / "ball.usda"))
    stage = Usd.Stage.CreateNew(str(tmp_path / "scene.usda"))
    UsdGeom.SetStageUpAxis(stage, "Z")
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    stage.DefinePrim("/World/one").GetReferences().AddReference("./ball.usda")
    stage.DefinePrim("/World/two").GetPayloads().AddPayload("./ball.usda")
    stage.GetRootLayer().Save()
    del stage
    model = load(tmp_path / "scene.usda")[0].compile()
    assert [model.body(i).name for i in (1, 2)] == ["ball", "two_ball"]


def _variants(author):
    a = _ball(author)
    sets = a.stage.GetPrimAtPath("/Robot").GetVariantSets().AddVariantSet("Physics")
    for name, radius in (("small", 0.1), ("big", 0.4)):
        sets.AddVariant(name)
        sets.SetVariantSelection(name)
        with sets.GetVariantEditContext():
            a.gprim("/Robot/ball/v", "Sphere", radius=radius)
    sets.SetVariantSelection("small")
    return a


def test_a_variant_is_chosen_for_the_import_alone(author):
    a = _variants(author)
    assert a.load()[0].geom("v").size[0] == pytest.approx(0.1)
    assert a.load(variants={"Physics": "big"})[0].geom("v").size[0] == pytest.approx(0.4)
    assert a.stage.GetPrimAtPath("/Robot").GetVariantSet("Physics").GetVariantSelection() == "small"


@pytest.mark.parametrize(
    ("variants", "message"), [({"Physics": "bgi"}, "did you mean 'big'"), ({"Physic": "big"}, "did you mean 'Physics'")]
)
def test_an_unknown_variant_proposes_the_nearest(author, variants, message):
    with pytest.raises(UsdImportError, match=message):
        _variants(author).load(variants=variants)


def test_a_missing_file_is_an_error_that_names_it(tmp_path):
    with pytest.raises(UsdImportError, match=r"none\.usda: no such file"):
        load(tmp_path / "none.usda")


@pytest.mark.parametrize(("name", "kind"), [("arm.urdf", "URDF"), ("arm.xml", r"XML \(MJCF\)")])
def test_a_robot_in_another_format_is_answered_with_the_way_to_convert_it(tmp_path, name, kind):
    (tmp_path / name).write_text("<robot/>")
    with pytest.raises(UsdImportError, match=rf"{name}: {kind} is not read: convert the file to USD first"):
        load(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "text"),
    [("broken.usda", '#usda 1.0\ndef Xform "A" {{{'), ("text.txt", "hello"), ("empty.usdc", ""), ("fake.usdz", "PK")],
)
def test_a_broken_layer_is_an_error_that_names_the_file(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(UsdImportError, match=name) as caught:
        load(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert isinstance(caught.value, (LiftLabError, ValueError))


@pytest.mark.parametrize(
    ("body", "prim"),
    [
        ('def Xform "A" (references = @./missing.usda@)\n{\n}', "/A"),
        ('def Xform "A" (payload = @./missing.usda@</B>)\n{\n}', "/A"),
        ('def Xform "A" (references = </Nowhere>)\n{\n}', "/A"),
        ('def Xform "A" (references = </A>)\n{\n}', "/A"),
    ],
)
def test_a_reference_that_does_not_resolve_is_an_error_that_names_the_prim(tmp_path, body, prim):
    (tmp_path / "scene.usda").write_text(f"#usda 1.0\n{body}\n")
    with pytest.raises(UsdImportError, match=rf"scene\.usda: <{prim}>\.references"):
        load(tmp_path / "scene.usda")


def test_a_missing_sublayer_is_an_error(tmp_path):
    (tmp_path / "scene.usda").write_text("#usda 1.0\n(\n    subLayers = [@./missing.usda@]\n)\n")
    with pytest.raises(UsdImportError, match="missing"):
        load(tmp_path / "scene.usda")


def test_an_empty_stage_is_an_empty_model(author):
    model, report = author().load()
    assert (model.nbody, report.bodies) == (1, [])


def test_importing_changes_neither_the_stage_nor_its_session_layer(author):
    a = _ball(author)
    before = a.stage.ExportToString(), a.stage.GetSessionLayer().ExportToString()
    a.load(scale=2.0)
    assert (a.stage.ExportToString(), a.stage.GetSessionLayer().ExportToString()) == before


@pytest.mark.parametrize("scale", [0.0, math.nan, (1, 2), (1, 0, 1)])
def test_a_scale_that_is_none_is_an_error(author, scale):
    with pytest.raises(UsdImportError, match="scale"):
        _ball(author).load(scale=scale)


def test_point_instances_with_rigid_bodies_become_bodies(author):
    a = author()
    instancer = UsdGeom.PointInstancer.Define(a.stage, "/Robot/crates")
    a.place(instancer.GetPrim(), pos=(0, 0, 1))
    a.body("/Robot/crates/kinds/box", mass=2.0)
    a.gprim("/Robot/crates/kinds/box/c", "Cube", size=0.2)
    a.body("/Robot/crates/kinds/ball", mass=3.0)
    a.gprim("/Robot/crates/kinds/ball/c", "Sphere", radius=0.1)
    instancer.CreatePrototypesRel().SetTargets(["/Robot/crates/kinds/box", "/Robot/crates/kinds/ball"])
    instancer.CreateProtoIndicesAttr([0, 1, 0, 0])
    instancer.CreatePositionsAttr([Gf.Vec3f(i, 0, 0) for i in range(4)])
    instancer.CreateOrientationsAttr([Gf.Quath(1, 0, 0, 0)] * 3 + [Gf.Quath(0, 0, 0, 1)])
    instancer.CreateInvisibleIdsAttr([2])
    instancer.CreateIdsAttr([0, 1, 2, 3])
    model, report = a.load()
    assert len(report.bodies) == 3
    np.testing.assert_allclose(model.body_mass[1:], (2, 3, 2))
    np.testing.assert_allclose(model.body_pos[1:], [(0, 0, 1), (1, 0, 1), (3, 0, 1)])
    np.testing.assert_allclose(np.abs(model.body_quat[3]), (0, 0, 0, 1), atol=1e-9)


def test_point_instances_that_point_nowhere_are_an_error(author):
    a = author()
    instancer = UsdGeom.PointInstancer.Define(a.stage, "/Robot/crates")
    a.gprim("/Robot/crates/box", "Cube", size=0.2)
    instancer.CreatePrototypesRel().SetTargets(["/Robot/crates/box"])
    instancer.CreateProtoIndicesAttr([3])
    instancer.CreatePositionsAttr([Gf.Vec3f(0)])
    with pytest.raises(UsdImportError, match=r"</Robot/crates>\.protoIndices"):
        a.load()


def test_instanceable_robots_are_read_through_their_instances(author):
    a = author()
    UsdGeom.Xform.Define(a.stage, "/Kit")
    a.body("/Kit/base")
    a.gprim("/Kit/base/c", "Cube", size=0.2)
    a.body("/Kit/link", pos=(0, 0, 1))
    a.joint("/Kit/w", "FixedJoint", None, "/Kit/base")
    a.joint("/Kit/j", "RevoluteJoint", "/Kit/base", "/Kit/link", "Z", pos0=(0, 0, 1))
    copy = a.stage.OverridePrim("/Robot/copy")
    copy.GetReferences().AddInternalReference("/Kit")
    copy.SetInstanceable(True)
    copy.SetSpecifier(Sdf.SpecifierDef)
    model, report = a.load()
    assert model.nv == 2
    assert report.prim_paths["base"].startswith("/Robot/copy")


def test_unknown_physics_is_reported_with_its_path_and_strict_refuses_it(author):
    a = _ball(author)
    a.attrs("/Robot/ball", {"physxRigidBody:linearDamping": 0.1, "physics:dance": 1.0}, "PhysxRigidBodyAPI")
    _, report = a.load()
    found = {note.attribute: note for note in report.ignored}
    assert found["physxRigidBody:linearDamping"].reason == "bodies have no damping of their own"
    assert found["physics:dance"].prim_path == "/Robot/ball"
    with pytest.raises(UsdImportError, match=r"</Robot/ball>\.phys"):
        a.load(strict=True)


def test_solver_settings_of_other_engines_are_noted_but_not_refused(author):
    a = _ball(author)
    a.attrs("/Robot/ball", {"physxRigidBody:solverPositionIterationCount": 8}, "PhysxRigidBodyAPI")
    _, report = a.load(strict=True)
    assert [note.tuning for note in report.ignored] == [True]


def test_initial_velocities_are_reported_as_ignored(author, notes):
    a = _ball(author)
    UsdPhysics.RigidBodyAPI(a.stage.GetPrimAtPath("/Robot/ball")).CreateVelocityAttr(Gf.Vec3f(1, 0, 0))
    assert notes(a.load()[1], "/Robot/ball")[0] == ["initial velocities are zero"]


def test_the_report_prints_as_a_table_that_folds_equal_notes(author):
    a = author()
    for i in range(3):
        body = a.body(f"/Robot/b{i}")
        a.attrs(body, {"physxRigidBody:linearDamping": 0.1})
    console = Console(width=160, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(a.load()[1].table())
    text = console.export_text()
    assert text.count("linearDamping") == 1
    assert "/Robot/b0 and 2 more" in text


@pytest.mark.parametrize(
    ("attribute", "value"),
    [
        ("xformOp:translate", Gf.Vec3d(0, math.nan, 0)),
        ("physics:mass", math.nan),
        ("newton:whatever", math.nan),
    ],
)
def test_nan_anywhere_is_an_error_that_names_prim_and_attribute(author, attribute, value):
    a = _ball(author)
    prim = a.stage.GetPrimAtPath("/Robot/ball")
    if prim.GetAttribute(attribute):
        prim.GetAttribute(attribute).Set(value)
    else:
        a.attrs(prim, {attribute: value})
    with pytest.raises(UsdImportError, match=rf"</Robot/ball>\.{attribute}: not a number"):
        a.load()


@pytest.mark.parametrize("metres", [0.0, -1.0, math.inf, 1e300])
def test_an_impossible_unit_is_an_error(author, metres):
    a = author("Z", metres)
    a.body("/Robot/b")
    with pytest.raises(UsdImportError, match="metersPerUnit"):
        a.load()


def test_an_attribute_of_an_unknown_type_is_an_error(tmp_path):
    body = 'def Xform "A" (apiSchemas = ["PhysicsRigidBodyAPI"])\n{\n    flozt mjc:gravcomp = 1\n}'
    (tmp_path / "scene.usda").write_text(f"#usda 1.0\n{body}\n")
    with pytest.raises(UsdImportError, match=r"</A>\.mjc:gravcomp: of a type that USD does not know"):
        load(tmp_path / "scene.usda")


def test_an_infinite_position_is_an_error(author):
    a = _ball(author)
    a.stage.GetPrimAtPath("/Robot/ball").GetAttribute("xformOp:translate").Set(Gf.Vec3d(math.inf, 0, 0))
    with pytest.raises(UsdImportError, match="/Robot/ball"):
        a.load()


@pytest.mark.filterwarnings("ignore:Attach conflict")
def test_models_made_from_the_same_file_attach_side_by_side(author):
    """The scene attaches specs with a prefix: names, excludes, equalities and actuators follow."""
    import mujoco

    a = author()
    a.body("/Robot/base")
    a.body("/Robot/link", pos=(0, 0, 1))
    a.joint("/Robot/w", "FixedJoint", None, "/Robot/base")
    joint = a.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z", pos0=(0, 0, 1))
    a.drive(joint, stiffness=1.0, targetPosition=10.0)
    parent = mujoco.MjSpec()
    for prefix in ("one/", "two/"):
        parent.attach(load(a.stage)[0], prefix=prefix, frame=parent.worldbody.add_frame())
    model = parent.compile()
    assert [model.joint(i).name for i in range(2)] == ["one/j", "two/j"]
    assert [model.actuator(i).name for i in range(2)] == ["one/j", "two/j"]
    assert model.nexclude == 2


def _row(stage, path, prototypes, count, step):
    instancer = UsdGeom.PointInstancer.Define(stage, path)
    instancer.CreatePrototypesRel().SetTargets(prototypes)
    instancer.CreateProtoIndicesAttr([0] * count)
    instancer.CreatePositionsAttr([Gf.Vec3f(*step) * i for i in range(count)])
    return instancer


def test_a_prototype_may_hold_an_instancer(author):
    a = author()
    _row(a.stage, "/Robot/rows", ["/Robot/rows/row"], 3, (10, 0, 0))
    UsdGeom.Xform.Define(a.stage, "/Robot/rows/row")
    _row(a.stage, "/Robot/rows/row/crates", ["/Robot/rows/row/crates/box"], 2, (0, 1, 0))
    a.body("/Robot/rows/row/crates/box", mass=None)
    a.gprim("/Robot/rows/row/crates/box/c", "Cube", size=0.2)
    model, _ = a.load()
    places = sorted(tuple(map(float, pos)) for pos in model.body_pos[1:])
    assert places == [(10.0 * i, 1.0 * j, 0.0) for i in range(3) for j in range(2)]


def test_an_instancer_in_an_instanced_reference_is_expanded(author):
    a = author()
    library = author()
    _row(library.stage, "/Robot/crates", ["/Robot/crates/box"], 2, (0, 1, 0))
    library.body("/Robot/crates/box", mass=None)
    library.gprim("/Robot/crates/box/c", "Cube", size=0.2)
    for name in ("left", "right"):
        prim = a.stage.DefinePrim(f"/Robot/{name}", "Xform")
        prim.GetReferences().AddReference(library.stage.GetRootLayer().identifier)
        prim.SetInstanceable(True)
    model, _ = a.load(strict=True)
    assert (model.nbody, model.ngeom) == (5, 4)


def test_instances_have_the_material_that_their_instancer_is_bound_to(author):
    a = author()
    slippery = a.material("/Robot/ice", dynamicFriction=0.25)
    instancer = _row(a.stage, "/Robot/crates", ["/Robot/crates/box"], 2, (0, 1, 0))
    a.gprim("/Robot/crates/box", "Cube", size=0.2)
    a.bind(instancer, slippery)
    model, _ = a.load()
    np.testing.assert_allclose(model.geom_friction[:, 0], 0.25)


def test_of_an_animated_prim_the_start_is_taken_and_reported(author, notes):
    a = author()
    body = a.body("/Robot/platform", mass=None)
    a.attrs(body, {"physics:kinematicEnabled": True})
    move = UsdGeom.Xformable(body).AddTranslateOp()
    cube = UsdGeom.Cube.Define(a.stage, "/Robot/platform/c")
    UsdPhysics.CollisionAPI.Apply(cube.GetPrim())
    for time, place in ((3, (5, 2, 3)), (24, (1, 2, 4))):
        move.Set(Gf.Vec3d(*place), time)
        cube.CreateSizeAttr().Set(0.1 * time, time)
    model, report = a.load()
    np.testing.assert_allclose(model.body("platform").pos, (5, 2, 3))
    np.testing.assert_allclose(model.geom("c").size, 0.15, rtol=1e-6)
    assert notes(report, "/Robot/platform")[1]
    assert notes(report, "/Robot/platform/c")[1]


@pytest.mark.parametrize("kind", ["", "Scope"])
def test_a_default_prim_without_a_transform_can_be_scaled(author, kind):
    a = author()
    stage = a.stage
    top = stage.DefinePrim("/Top", kind)
    stage.SetDefaultPrim(top)
    a.gprim("/Top/c", "Cube", size=0.2, pos=(1, 0, 0))
    model, _ = a.load(scale=2.0)
    np.testing.assert_allclose(model.geom("c").size, 0.2)
    np.testing.assert_allclose(model.geom("c").pos, (2, 0, 0))


def test_a_mass_without_its_schema_is_reported(author, notes):
    """usd-core takes no mass from a prim that does not apply MassAPI."""
    a = author()
    body = a.body("/Robot/box", mass=None)
    a.gprim("/Robot/box/c", "Cube", size=0.2)
    body.CreateAttribute("physics:mass", Sdf.ValueTypeNames.Float).Set(3.0)
    model, report = a.load()
    np.testing.assert_allclose(model.body("box").mass, 8.0)
    assert notes(report, "/Robot/box")[0] == ["PhysicsMassAPI is not applied to the prim"]
