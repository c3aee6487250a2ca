"""CollisionAPI on a prim that is no shape makes colliders of the shapes below, as in PhysX."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from lift_lab.usd import UsdImportError, load

TETRAHEDRON = [(0, 0, 0), (0.6, 0, 0), (0, 0.4, 0), (0, 0, 0.2)], [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]


def _colliders(model) -> list[str]:
    return [model.geom(i).name for i in range(model.ngeom) if model.geom_contype[i] or model.geom_conaffinity[i]]


def _collision(a, path, *schemas):
    """Apply CollisionAPI to a prim of any type, with further schemas."""
    prim = a.stage.GetPrimAtPath(path)
    for schema in ("PhysicsCollisionAPI", *schemas):
        prim.AddAppliedSchema(schema)
    return prim


@pytest.fixture
def layout(author):
    """A body whose shapes stand below a prim of the given type: a box, and deeper a ball."""

    def make(kind="Xform", instanced=False, metres=1.0):
        a = author("Z", metres)
        a.body("/Robot/link", mass=None)
        a.place(a.stage.DefinePrim("/Robot/link/collisions", kind)) if kind == "Xform" else None
        path = "/Robot/link/collisions"
        if instanced:
            for prototype in ("/proto", "/inner"):
                a.stage.CreateClassPrim(prototype).SetTypeName("Xform")
            a.gprim("/proto/box", "Cube", pos=(0.1, 0, 0), scale=(2, 1, 1), collider=False, size=0.2)
            a.gprim("/inner/ball", "Sphere", collider=False, radius=0.05)
            inner = UsdGeom.Xform.Define(a.stage, "/proto/deep").GetPrim()
            inner.GetReferences().AddInternalReference("/inner")
            inner.SetInstanceable(True)
            holder = a.stage.GetPrimAtPath(path) or a.stage.DefinePrim(path, kind)
            holder.GetReferences().AddInternalReference("/proto")
            holder.SetInstanceable(True)
        else:
            if not a.stage.GetPrimAtPath(path):
                a.stage.DefinePrim(path, kind)
            a.gprim(f"{path}/box", "Cube", pos=(0.1, 0, 0), scale=(2, 1, 1), collider=False, size=0.2)
            UsdGeom.Xform.Define(a.stage, f"{path}/deep")
            a.gprim(f"{path}/deep/ball", "Sphere", collider=False, radius=0.05)
        _collision(a, path)
        return a

    return make


@pytest.mark.parametrize("instanced", [False, True])
@pytest.mark.parametrize("kind", ["Xform", "Scope", ""])
def test_shapes_below_a_prim_with_collision_api_collide_and_weigh(layout, kind, instanced):
    a = layout(kind, instanced)
    before = a.stage.GetRootLayer().ExportToString()
    model, report = a.load(strict=True)
    assert sorted(_colliders(model)) == ["ball", "box"]
    assert model.geom("box").type[0] == mujoco.mjtGeom.mjGEOM_BOX
    np.testing.assert_allclose(model.geom("box").size, (0.2, 0.1, 0.1))
    np.testing.assert_allclose(model.geom("box").pos, (0.1, 0, 0))
    box, ball = 1000 * 0.4 * 0.2 * 0.2, 1000 * 4 / 3 * math.pi * 0.05**3
    assert model.body("link").mass[0] == pytest.approx(box + ball, rel=1e-6)
    assert model.body("link").ipos[0] == pytest.approx(0.1 * box / (box + ball), rel=1e-6)
    assert (report.ignored, report.approximated) == ([], [])
    assert a.stage.GetRootLayer().ExportToString() == before
    assert a.stage.GetSessionLayer().ExportToString().count("over") == 0


def test_a_box_of_an_instanced_collider_rests_on_the_ground(layout):
    spec, _ = load(layout(instanced=True).stage)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], pos=[0, 0, -0.3])
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 800)
    assert data.body("link").xpos[2] == pytest.approx(-0.3 + 0.1, abs=2e-3)


def test_the_body_itself_may_carry_the_schema(author):
    a = author()
    body = a.body("/Robot/link")
    a.gprim("/Robot/link/box", "Cube", collider=False, size=0.2)
    _collision(a, body.GetPath())
    model, _ = a.load()
    assert _colliders(model) == ["box"]
    assert model.body("link").mass[0] == pytest.approx(1.0)  # the body's own


@pytest.mark.parametrize(
    ("approximation", "kind"), [("boundingCube", "BOX"), ("boundingSphere", "SPHERE"), (None, "MESH")]
)
def test_the_approximation_holds_for_meshes_below(author, approximation, kind):
    a = author()
    a.body("/Robot/link")
    UsdGeom.Xform.Define(a.stage, "/Robot/link/collisions")
    a.mesh("/Robot/link/collisions/mesh", *TETRAHEDRON, collider=False)
    a.gprim("/Robot/link/collisions/ball", "Sphere", collider=False, radius=0.05)
    owner = _collision(a, "/Robot/link/collisions", "PhysicsMeshCollisionAPI")
    if approximation:
        UsdPhysics.MeshCollisionAPI(owner).CreateApproximationAttr(approximation)
    model, report = a.load(strict=True)
    geom = next(g for g in map(model.geom, _colliders(model)) if g.name != "ball")
    assert geom.type[0] == getattr(mujoco.mjtGeom, f"mjGEOM_{kind}")
    if kind == "BOX":
        np.testing.assert_allclose(geom.size, (0.3, 0.2, 0.1), atol=1e-7)
    assert report.approximated == []


def test_material_and_contact_attributes_are_inherited_and_a_shapes_own_win(layout):
    a = layout(metres=0.01)
    owner = a.stage.GetPrimAtPath("/Robot/link/collisions")
    a.bind(owner, a.material("/Robot/rubber", dynamicFriction=0.7, staticFriction=0.7))
    a.attrs(owner, {"physxCollision:contactOffset": 5.0, "physxCollision:restOffset": 1.0}, "PhysxCollisionAPI")
    a.attrs("/Robot/link/collisions/box", {"physxCollision:restOffset": 2.0})
    model, report = a.load(strict=True)
    for name, rest in (("ball", 0.01), ("box", 0.02)):
        assert model.geom(name).friction[0] == pytest.approx(0.7)
        assert model.geom(name).margin[0] == pytest.approx(rest)
        assert model.geom(name).gap[0] == pytest.approx(0.05 - rest)
    assert report.ignored == []


def test_what_is_ignored_is_said_of_the_prim_that_authors_it(layout):
    a = layout()
    a.attrs("/Robot/link/collisions", {"physxCollision:torsionalPatchRadius": 0.1}, "PhysxCollisionAPI")
    assert [n.prim_path for n in a.load()[1].ignored] == ["/Robot/link/collisions"]


@pytest.mark.parametrize("at", ["/Robot/link/collisions", "/Robot/link/collisions/box"])
def test_a_switched_off_prim_has_no_colliders(layout, at):
    a = layout()
    a.attrs(at, {"physics:collisionEnabled": False})
    assert _colliders(a.load()[0]) == (["ball"] if at.endswith("box") else [])


def test_the_nearest_prim_above_counts_and_a_shapes_own_schema_stays(layout):
    a = layout()
    a.attrs("/Robot/link/collisions", {"physxCollision:restOffset": 0.01})
    a.attrs(_collision(a, "/Robot/link/collisions/deep"), {"physxCollision:restOffset": 0.02})
    _collision(a, "/Robot/link/collisions/box")
    model, _ = a.load()
    assert model.geom("ball").margin[0] == pytest.approx(0.02)
    assert model.geom("box").margin[0] == 0


def test_shapes_of_bodies_below_belong_to_those_bodies(author, notes):
    a = author()
    for name, x in (("a", 0), ("b", 1)):
        a.body(f"/Robot/{name}", pos=(x, 0, 0), mass=None)
        a.gprim(f"/Robot/{name}/box_{name}", "Cube", collider=False, size=0.2)
    _collision(a, "/Robot")
    a.mass("/Robot", mass=5.0)
    model, report = a.load()
    for name in "ab":
        assert model.geom(f"box_{name}").bodyid[0] == model.body(name).id
        assert model.body(name).mass[0] == pytest.approx(8.0)
    assert set(notes(report, "/Robot")[0]) == {"its colliders belong to bodies below it"}


@pytest.mark.parametrize(
    ("values", "mass"),
    [
        ({"mass": 3.0}, 3.0),
        ({"density": 10.0}, 10.0 * (0.016 + 4 / 3 * math.pi * 0.05**3)),
        ({"mass": 3.0, "diagonalInertia": Gf.Vec3f(1, 2, 3), "centerOfMass": Gf.Vec3f(0, 0, 0.5)}, 3.0),
    ],
)
def test_mass_properties_beside_the_schema_are_those_of_all_shapes_together(layout, values, mass):
    a = layout()
    a.gprim("/Robot/link/more", "Cube", pos=(-1, 0, 0), size=0.1)  # 1 kg
    a.mass("/Robot/link/collisions", **values)
    model, report = a.load(strict=True)
    link = model.body("link")
    assert link.mass[0] == pytest.approx(mass + 1.0, rel=1e-6)
    if "centerOfMass" in values:
        com = np.array([-1.0, 0, 1.5]) / 4
        np.testing.assert_allclose(link.ipos, com, atol=1e-6)
        points = [(3.0, np.array([0, 0, 0.5]) - com), (1.0, np.array([-1.0, 0, 0]) - com)]
        tensor = np.diag([1, 2, 3]) + np.eye(3) * 0.1**2 / 6
        tensor = tensor + sum(m * (d @ d * np.eye(3) - np.outer(d, d)) for m, d in points)
        np.testing.assert_allclose(sorted(link.inertia), np.linalg.eigvalsh(tensor), rtol=1e-5)
    assert report.ignored == []


@pytest.mark.parametrize("rule", [Usd.Tokens.expandPrims, Usd.Tokens.explicitOnly])
@pytest.mark.parametrize("instanced", [False, True])
def test_a_collision_group_of_the_prim_holds_for_its_shapes(layout, rule, instanced):
    a = layout(instanced=instanced)
    a.gprim("/Robot/floor", "Cube", size=1.0)
    for name, member in (("one", "/Robot/link/collisions"), ("two", "/Robot/floor")):
        group = UsdPhysics.CollisionGroup.Define(a.stage, f"/{name}")
        collection = group.GetCollidersCollectionAPI()
        collection.CreateExpansionRuleAttr(rule)
        collection.CreateIncludesRel().AddTarget(member)
    UsdPhysics.CollisionGroup.Get(a.stage, "/one").CreateFilteredGroupsRel().AddTarget("/two")
    assert _pairs(a.load()[0]) == set()


@pytest.mark.parametrize("source", ["/Robot/link/collisions", "/Robot/floor"])
@pytest.mark.parametrize("instanced", [False, True])
def test_a_filtered_pair_with_the_prim_holds_for_its_shapes(layout, source, instanced):
    a = layout(instanced=instanced)
    a.gprim("/Robot/floor", "Cube", size=1.0)
    a.gprim("/Robot/link/tip", "Sphere", pos=(-0.1, 0, 0), radius=0.02)
    ends = ["/Robot/link/collisions", "/Robot/floor"]
    other = ends[1 - ends.index(source)]
    UsdPhysics.FilteredPairsAPI.Apply(a.stage.GetPrimAtPath(source)).CreateFilteredPairsRel().AddTarget(other)
    assert _pairs(a.load()[0]) == {("floor", "tip")}


def _pairs(model) -> set[tuple[str, str]]:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return {tuple(sorted(model.geom(g).name for g in contact.geom)) for contact in data.contact}


def test_sites_and_soft_bodies_below_stay_what_they_are(author):
    a = author()
    a.body("/Robot/link")
    UsdGeom.Xform.Define(a.stage, "/Robot/link/geometry")
    a.set(a.gprim("/Robot/link/geometry/mark", "Sphere", collider=False, radius=0.01), "MjcSiteAPI")
    soft = a.mesh("/Robot/link/geometry/soft", *TETRAHEDRON, collider=False)
    a.set(soft, "PhysxDeformableBodyAPI")
    a.gprim("/Robot/link/geometry/box", "Cube", collider=False, size=0.2)
    _collision(a, "/Robot/link/geometry")
    model, report = a.load()
    assert _colliders(model) == ["box"]
    assert model.nsite == 1
    assert len(report.soft_bodies) == 1


def test_merged_meshes_collide_one_by_one_and_only_the_members(author, notes):
    a = author()
    a.body("/Robot/link")
    UsdGeom.Xform.Define(a.stage, "/Robot/link/geometry")
    for name in ("in", "out"):
        a.mesh(f"/Robot/link/geometry/{name}", *TETRAHEDRON, collider=False)
    owner = _collision(a, "/Robot/link/geometry", "PhysxMeshMergeCollisionAPI", "CollectionAPI:collisionmeshes")
    includes = owner.CreateRelationship("collection:collisionmeshes:includes")
    includes.AddTarget(Sdf.Path("/Robot/link/geometry/in"))
    model, report = a.load()
    assert _colliders(model) == ["in"]
    ignored, approximated = notes(report, "/Robot/link/geometry")
    assert "not merged" in approximated[0]
    assert ignored == []
    includes.AddTarget(Sdf.Path("/Robot/elsewhere"))
    assert "not below the prim" in notes(a.load()[1], "/Robot/link/geometry")[0][0]


@pytest.mark.parametrize(
    ("schema", "instanced"),
    [
        ("NewtonCollisionAPI", False), ("NewtonSDFCollisionAPI", False), ("MjcCollisionAPI", False),
        ("MjcMeshCollisionAPI", False), ("NewtonMeshCollisionAPI", True),
    ],
)  # fmt: skip
def test_a_vendors_schema_brings_the_one_built_into_it(author, schema, instanced):
    """Where Newton's and MuJoCo's schemas are registered, they make a collider without naming PhysicsCollisionAPI."""
    a = author()
    body = a.body("/Robot/link", mass=None)
    if instanced:
        a.stage.CreateClassPrim("/proto").SetTypeName("Xform")
        UsdGeom.Xform.Define(a.stage, "/Robot/link/geometry").GetPrim().GetReferences().AddInternalReference("/proto")
        a.stage.GetPrimAtPath("/Robot/link/geometry").SetInstanceable(True)
    mesh = a.mesh("/proto/mesh" if instanced else "/Robot/link/mesh", *TETRAHEDRON, collider=False)
    mesh.AddAppliedSchema(schema)
    body.AddAppliedSchema("NewtonMassAPI")
    a.attrs(body, {"physics:mass": 2.0})
    if "Mesh" in schema:
        a.attrs(mesh, {"physics:approximation": "boundingCube"})
    model, report = a.load(strict=True)
    assert len(_colliders(model)) == 1
    assert model.body("link").mass[0] == pytest.approx(2.0)
    assert report.ignored == []
    if "Mesh" in schema:
        assert model.geom(_colliders(model)[0]).type[0] == mujoco.mjtGeom.mjGEOM_BOX


def test_a_vendors_material_and_root_bring_those_built_in(author):
    a = author()
    a.body("/Robot/link")
    a.bind(a.gprim("/Robot/link/box", "Cube", size=0.2), a.material("/Robot/m", dynamicFriction=0.3))
    material = a.stage.GetPrimAtPath("/Robot/m")
    material.RemoveAPI(UsdPhysics.MaterialAPI)
    material.AddAppliedSchema("NewtonMaterialAPI")
    a.set("/Robot", "NewtonArticulationRootAPI")
    model, report = a.load(strict=True)
    assert model.geom("box").friction[0] == pytest.approx(0.3)
    assert report.articulation_roots == ["/Robot"]


def test_a_prim_without_shapes_below_is_reported_and_strict_refuses_it(author, notes):
    a = author()
    a.body("/Robot/link")
    UsdGeom.Xform.Define(a.stage, "/Robot/link/empty")
    _collision(a, "/Robot/link/empty")
    assert "no collision shape below the prim" in notes(a.load()[1], "/Robot/link/empty")[0][0]
    with pytest.raises(UsdImportError, match=r"</Robot/link/empty>\.PhysicsCollisionAPI"):
        a.load(strict=True)


def test_a_prim_above_colliders_of_their_own_loses_nothing(author):
    a = author()
    a.body("/Robot/link")
    a.gprim("/Robot/link/box", "Cube", size=0.2)
    _collision(a, "/Robot/link")
    model, report = a.load(strict=True)
    assert _colliders(model) == ["box"]
    assert report.ignored == []


def test_a_joint_to_a_static_prim_spares_the_shapes_below_it(layout):
    """The joint's bodies do not touch: on the world's side those are the colliders below the prim it names."""
    a = layout()
    UsdGeom.Xform.Define(a.stage, "/Robot/base")
    a.gprim("/Robot/base/plate", "Cube", collider=False, size=1.0)
    _collision(a, "/Robot/base")
    a.gprim("/Robot/wall", "Cube", size=1.0)
    a.joint("/Robot/j", "RevoluteJoint", "/Robot/base", "/Robot/link", "Z")
    assert {pair[1] for pair in _pairs(a.load()[0])} == {"wall"}


ISAAC = """#usda 1.0
(
    defaultPrim = "robot"
    metersPerUnit = 1
    upAxis = "Z"
)
def Xform "robot"
{
    def Xform "base" (prepend apiSchemas = ["PhysicsRigidBodyAPI"])
    {
        double3 xformOp:translate = (0, 0, 0.5)
        uniform token[] xformOpOrder = ["xformOp:translate"]
        def Xform "collisions" (
            instanceable = true
            prepend references = </colliders/base>
        )
        {
        }
    }
}
def Scope "colliders"
{
    token visibility = "invisible"
    def Xform "base"
    {
        def Xform "node" (prepend apiSchemas = ["PhysicsCollisionAPI", "PhysicsMeshCollisionAPI"])
        {
            def "part" (prepend references = </meshes/box>)
            {
            }
        }
        def Cube "plate" (prepend apiSchemas = ["PhysicsCollisionAPI"])
        {
            double size = 0.1
        }
    }
}
def Scope "meshes"
{
    def Cube "box"
    {
        double size = 0.2
    }
}
def Cube "floor" (prepend apiSchemas = ["PhysicsCollisionAPI"])
{
    double size = 2
}
"""


@pytest.mark.parametrize("arc", ["references", "payload", "inherits", "specializes"])
def test_prims_that_the_default_prim_refers_to_are_its_parts_alone(tmp_path, arc):
    """Isaac Sim's URDF importer keeps shapes in scopes beside the robot: they do not also stand at the origin."""
    path = tmp_path / "robot.usda"
    path.write_text(ISAAC.replace("references = </meshes", f"{arc} = </meshes"))
    spec, report = load(path, strict=True)
    model = spec.compile()
    owners = {model.geom(i).name: model.body(model.geom_bodyid[i]).name for i in range(model.ngeom)}
    assert owners == {"part": "base", "plate": "base", "floor": "floor"}
    assert sorted(_colliders(model)) == ["floor", "part", "plate"]
    assert model.body("base").mass[0] == pytest.approx(8.0 + 1.0)
    assert report.root_bodies == ["base", "floor"]
