"""Colliders: sizes, poses, scales, approximations, materials and contact parameters."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import pytest
from pxr import Gf, UsdGeom, UsdPhysics
from scipy.spatial.transform import Rotation

from lift_lab.usd import UsdImportError

GEOM = mujoco.mjtGeom
BOX_POINTS = [(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]
BOX_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
L_POINTS = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]


def _mat(quat):
    return Rotation.from_quat(np.roll(np.asarray(quat, dtype=float), -1)).as_matrix()


def _geom_world(model, name):
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return data.geom(name).xpos.copy(), data.geom(name).xmat.reshape(3, 3).copy()


def _mesh_world(model, name):
    """World vertices of a mesh geom, rows sorted."""
    mesh = int(model.geom(name).dataid[0])
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    pos, mat = _geom_world(model, name)
    vertices = model.mesh_vert[start : start + count] @ mat.T + pos
    return vertices[np.lexsort(np.round(vertices, 4).T)]


def _sorted(points):
    points = np.asarray(points, dtype=float)
    return points[np.lexsort(np.round(points, 4).T)]


@pytest.mark.parametrize(("axis", "turned"), [("X", (1, 0, 0)), ("Y", (0, 1, 0)), ("Z", (0, 0, 1))])
@pytest.mark.parametrize("kind", ["Capsule", "Cylinder"])
def test_round_shapes_turn_onto_their_axis_and_capsule_height_excludes_the_caps(author, kind, axis, turned):
    a = author("Z", 0.01)
    a.gprim("/Robot/c", kind, pos=(10, 20, 30), radius=5.0, height=40.0, axis=axis)
    model, _ = a.load()
    assert model.geom("c").type[0] == getattr(GEOM, f"mjGEOM_{kind.upper()}")
    np.testing.assert_allclose(model.geom("c").size[:2], (0.05, 0.2))
    np.testing.assert_allclose(model.geom("c").pos, (0.1, 0.2, 0.3))
    np.testing.assert_allclose(np.abs(_mat(model.geom("c").quat)[:, 2]), turned, atol=1e-9)


@pytest.mark.parametrize("kind", ["Cube", "Sphere", "Capsule", "Cylinder"])
def test_uniformly_scaled_shapes_have_the_sizes_of_usd_cores_descriptors(author, kind):
    a = author("Z", 0.1)
    a.place(a.stage.GetPrimAtPath("/Robot"), scale=(1.5, 1.5, 1.5))
    a.body("/Robot/b", scale=(2, 2, 2))
    a.gprim("/Robot/b/c", kind, pos=(1, 2, 3), quat=(0.5, 0.5, 0.5, 0.5))
    (desc,) = next(
        descs
        for shape, (_, descs) in UsdPhysics.UsdPhysicsLoadStageFromPrimRange(a.stage, ["/"]).items()
        if shape.name.endswith("Shape")
    )
    expected = {
        "Cube": lambda: desc.halfExtents,
        "Sphere": lambda: (desc.radius,),
        "Capsule": lambda: (desc.radius, desc.halfHeight),
        "Cylinder": lambda: (desc.radius, desc.halfHeight),
    }[kind]()
    model, _ = a.load()
    np.testing.assert_allclose(model.geom("c").size[: len(expected)], np.array(expected) * 0.1, rtol=1e-6)
    np.testing.assert_allclose(model.geom("c").pos, np.array(desc.localPos) * 0.1, rtol=1e-6)


def test_a_non_uniformly_scaled_sphere_is_an_ellipsoid(author):
    a = author()
    a.gprim("/Robot/c", "Sphere", scale=(1, 2, -3), radius=0.5)
    model, _ = a.load()
    assert model.geom("c").type[0] == GEOM.mjGEOM_ELLIPSOID
    np.testing.assert_allclose(model.geom("c").size, (0.5, 1.0, 1.5))


def test_a_negatively_scaled_box_keeps_positive_sizes(author):
    a = author()
    a.gprim("/Robot/c", "Cube", scale=(-1, 2, 3), size=2.0)
    np.testing.assert_allclose(a.load()[0].geom("c").size, (1, 2, 3))


def test_a_box_sheared_by_its_parents_scale_becomes_the_exact_mesh(author):
    a = author()
    rot = Rotation.from_euler("z", 30, degrees=True)
    a.body("/Robot/b", scale=(1, 2, 1))
    a.gprim("/Robot/b/c", "Cube", quat=np.roll(rot.as_quat(), 1), size=1.0)
    model, _ = a.load()
    assert model.geom("c").type[0] == GEOM.mjGEOM_MESH
    corners = np.array(BOX_POINTS) @ rot.as_matrix().T * (1, 2, 1)
    np.testing.assert_allclose(_mesh_world(model, "c"), _sorted(corners), atol=1e-6)


@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 3, 4), (-1, 1, 1), (-1, -2, -3)])
def test_mesh_vertices_and_winding_survive_any_scale(author, scale):
    points = [(0, 0, 0), (0.6, 0, 0), (0, 0.5, 0), (0, 0, 0.4)]
    a = author("Y", 0.5)
    a.mesh("/Robot/c", points, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)], pos=(1, 2, 3), scale=scale)
    model, _ = a.load()
    world = (np.array(points) * scale + (1, 2, 3)) * 0.5
    world = np.stack([world[:, 0], -world[:, 2], world[:, 1]], axis=1)
    np.testing.assert_allclose(_mesh_world(model, "c"), _sorted(world), atol=1e-6)
    # faces look outward: normals point away from the centroid
    mesh = int(model.geom("c").dataid[0])
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    p = vertices[faces]
    normals = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    outward = np.einsum("ij,ij->i", normals, p.mean(axis=1) - vertices.mean(axis=0))
    assert (outward > 0).all()


def test_left_handed_meshes_are_turned_inside_out(author):
    a = author()
    prim = a.mesh(
        "/Robot/c", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [(0, 1, 2), (0, 3, 1), (1, 3, 2), (0, 2, 3)]
    )
    UsdGeom.Mesh(prim).CreateOrientationAttr("leftHanded")
    model, _ = a.load()
    p = model.mesh_vert[model.mesh_face]
    normals = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert (np.einsum("ij,ij->i", normals, p.mean(axis=1) - model.mesh_vert.mean(axis=0)) > 0).all()


def _approximated(author, approximation, points=BOX_POINTS, faces=BOX_FACES, **options):
    a = author()
    a.body("/Robot/b")
    a.mesh("/Robot/b/c", points, faces, approximation=approximation, **options)
    return a.load()


def test_bounding_cube_is_a_box_beside_the_picture_of_the_mesh(author):
    model, _ = _approximated(author, "boundingCube", pos=(1, 0, 0), scale=(0.2, 0.4, 0.6))
    box, picture = model.geom("c"), model.geom("b_c")
    assert box.type[0] == GEOM.mjGEOM_BOX
    np.testing.assert_allclose(box.size, (0.1, 0.2, 0.3), atol=1e-7)
    np.testing.assert_allclose(box.pos, (1, 0, 0), atol=1e-7)
    assert (box.group[0], picture.group[0], picture.contype[0]) == (3, 2, 0)


def test_bounding_sphere_reaches_the_farthest_vertex(author):
    model, _ = _approximated(author, "boundingSphere")
    assert model.geom("c").type[0] == GEOM.mjGEOM_SPHERE
    assert model.geom("c").size[0] == pytest.approx(math.sqrt(0.75))


def _prism():
    low = [(x, y, 0) for x, y in L_POINTS]
    high = [(x, y, 1) for x, y in L_POINTS]
    n = len(L_POINTS)
    sides = [(i, (i + 1) % n, (i + 1) % n + n, i + n) for i in range(n)]
    caps = [(5, 4, 3, 0), (3, 2, 1, 0), (6, 9, 10, 11), (6, 7, 8, 9)]
    return low + high, sides + caps


@pytest.mark.parametrize("approximation", ["none", "meshSimplification", "sdf", "convexDecomposition", "sphereFill"])
def test_a_concave_mesh_that_collides_as_its_hull_is_reported(author, notes, approximation):
    points, faces = _prism()
    _, report = _approximated(author, approximation, points, faces)
    assert "convex hull" in notes(report, "/Robot/b/c")[1][0]


def test_an_approximation_that_does_not_exist_is_reported(author, notes):
    model, report = _approximated(author, "convexHul")
    assert model.ngeom == 1
    assert "'convexHul' is none of" in notes(report, "/Robot/b/c")[0][0]


@pytest.mark.parametrize("approximation", ["none", "convexHull", None])
def test_a_convex_mesh_is_exact_and_not_reported(author, notes, approximation):
    model, report = _approximated(author, approximation)
    assert model.geom("c").type[0] == GEOM.mjGEOM_MESH
    assert notes(report, "/Robot/b/c") == ([], [])


def test_a_flat_collision_mesh_is_a_thin_slab_below_its_face(author, notes):
    a = author()
    a.mesh("/Robot/floor", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)], approximation="none")
    a.body("/Robot/ball", pos=(0, 0, 0.2))
    a.gprim("/Robot/ball/c", "Sphere", radius=0.1)
    model, report = a.load()
    assert "thin slab" in notes(report, "/Robot/floor")[1][0]
    data = mujoco.MjData(model)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    assert data.body("ball").xpos[2] == pytest.approx(0.1, abs=2e-3)


def test_a_hull_vertex_limit_is_kept(author):
    a = author()
    prim = a.mesh("/Robot/c", BOX_POINTS, BOX_FACES, approximation="convexHull")
    a.attrs(prim, {"newton:maxHullVertices": 16})
    from lift_lab.usd import load

    assert load(a.stage)[0].meshes[0].maxhullvert == 16


def test_two_meshes_with_the_same_vertices_share_one_asset(author):
    a = author()
    for i in range(3):
        a.mesh(f"/Robot/part{i}", BOX_POINTS, BOX_FACES, pos=(i, 0, 0))
    model, _ = a.load()
    assert (model.ngeom, model.nmesh) == (3, 1)


def test_an_infinite_plane_stays_a_plane_and_on_a_moving_body_becomes_a_box(author, notes):
    a = author()
    a.gprim("/Robot/floor", "Plane", axis="Y", width=4.0, length=6.0)
    a.body("/Robot/b", pos=(0, 0, 1))
    a.gprim("/Robot/b/plate", "Plane", width=0.4, length=0.6)
    model, report = a.load()
    floor, plate = model.geom("floor"), model.geom("plate")
    assert floor.type[0] == GEOM.mjGEOM_PLANE
    np.testing.assert_allclose(_mat(floor.quat)[:, 2], (0, 1, 0), atol=1e-9)
    np.testing.assert_allclose(floor.size[:2], (2, 3))
    assert plate.type[0] == GEOM.mjGEOM_BOX
    np.testing.assert_allclose(plate.size[:2], (0.2, 0.3))
    assert "thin box" in notes(report, "/Robot/b/plate")[1][0]


def test_a_cone_is_a_mesh_of_its_size(author):
    a = author()
    a.gprim("/Robot/c", "Cone", radius=0.5, height=2.0, axis="X")
    model, _ = a.load()
    vertices = _mesh_world(model, "c")
    np.testing.assert_allclose(np.ptp(vertices, axis=0), (2, 1, 1), atol=1e-6)
    tip = vertices[np.argmax(vertices[:, 0])]
    np.testing.assert_allclose(tip, (1, 0, 0), atol=1e-6)


def test_static_colliders_hang_on_one_body_named_after_the_default_prim(author):
    a = author()
    a.place(a.stage.GetPrimAtPath("/Robot"), pos=(0, 0, 2))
    a.gprim("/Robot/top", "Cube", pos=(0, 0, 1), size=0.2)
    a.gprim("/Robot/leg", "Cube", size=0.2)
    model, report = a.load()
    assert report.bodies == ["Robot"]
    np.testing.assert_allclose(model.body("Robot").pos, (0, 0, 2))
    np.testing.assert_allclose(model.geom("top").pos, (0, 0, 1))
    assert model.nv == 0


def test_static_colliders_beside_the_default_prim_have_their_own_body(author):
    a = author()
    a.gprim("/Robot/top", "Cube", size=0.2)
    a.gprim("/Ground/plane", "Plane")
    assert a.load()[1].bodies == ["Robot", "Ground"]


@pytest.mark.parametrize(
    ("purpose", "visible", "group"),
    [("default", True, 0), ("render", True, 0), ("guide", True, 3), ("default", False, 3)],
)
def test_colliders_that_do_not_render_go_to_group_three(author, purpose, visible, group):
    a = author()
    prim = a.gprim("/Robot/c", "Cube", size=0.2)
    UsdGeom.Imageable(prim).CreatePurposeAttr(purpose)
    if not visible:
        UsdGeom.Imageable(prim).MakeInvisible()
    model, _ = a.load()
    assert model.geom("c").group[0] == group
    assert model.geom("c").contype[0] == 1


def test_dynamic_friction_is_the_coefficient_and_a_different_static_one_is_reported(author, notes):
    a = author()
    prim = a.gprim("/Robot/c", "Cube", size=0.2)
    a.bind(prim, a.material("/Robot/m", dynamicFriction=0.6, staticFriction=0.9))
    model, report = a.load()
    assert model.geom("c").friction[0] == pytest.approx(0.6)
    assert "one coefficient" in notes(report, "/Robot/m")[1][0]


def test_a_material_bound_for_physics_beats_one_for_all_purposes(author):
    a = author()
    prim = a.gprim("/Robot/c", "Cube", size=0.2)
    a.bind(prim, a.material("/Robot/m1", dynamicFriction=0.1, staticFriction=0.1), purpose="")
    a.bind(prim, a.material("/Robot/m2", dynamicFriction=0.2, staticFriction=0.2), purpose="physics")
    assert a.load()[0].geom("c").friction[0] == pytest.approx(0.2)


def test_a_material_bound_to_an_ancestor_for_all_purposes_counts(author):
    a = author()
    a.gprim("/Robot/group/c", "Cube", size=0.2)
    a.bind("/Robot/group", a.material("/Robot/m", dynamicFriction=0.3, staticFriction=0.3), purpose="")
    assert a.load()[0].geom("c").friction[0] == pytest.approx(0.3)


def test_torsional_and_rolling_friction_are_lengths(author):
    a = author("Z", 0.01)
    prim = a.gprim("/Robot/c", "Cube", size=20.0)
    material = a.material("/Robot/m", dynamicFriction=0.5)
    a.attrs(material.GetPrim(), {"newton:torsionalFriction": 2.0, "newton:rollingFriction": 0.1}, "NewtonMaterialAPI")
    a.bind(prim, material)
    np.testing.assert_allclose(a.load()[0].geom("c").friction, (0.5, 0.02, 0.001), rtol=1e-6)


def test_mjc_torsional_and_rolling_friction_are_metres(author):
    a = author("Z", 0.01)
    prim = a.gprim("/Robot/c", "Cube", size=20.0)
    material = a.material("/Robot/m", dynamicFriction=0.5)
    a.attrs(material.GetPrim(), {"mjc:torsionalfriction": 0.02, "mjc:rollingfriction": 0.003}, "MjcMaterialAPI")
    a.bind(prim, material)
    np.testing.assert_allclose(a.load()[0].geom("c").friction, (0.5, 0.02, 0.003), rtol=1e-6)


def test_restitution_is_ignored_with_a_note_unless_asked_for(author, notes):
    a = author()
    prim = a.gprim("/Robot/c", "Cube", size=0.2)
    a.bind(prim, a.material("/Robot/m", restitution=0.5))
    model, report = a.load()
    np.testing.assert_allclose(model.geom("c").solref, (0.02, 1))
    assert "bounce" in notes(report, "/Robot/m")[0][0]


@pytest.mark.parametrize("restitution", [0.1, 0.3, 0.6, 0.9])
def test_an_opted_in_restitution_rebounds_about_as_it_says(author, restitution):
    """A dropped ball leaves the floor at roughly the stated share of its impact speed."""
    a = author()
    floor = a.gprim("/Robot/floor", "Plane")
    a.body("/Robot/ball", pos=(0, 0, 1.1))
    ball = a.gprim("/Robot/ball/c", "Sphere", radius=0.1)
    material = a.material("/Robot/m", restitution=restitution)
    a.bind(floor, material)
    a.bind(ball, material)
    model, _ = a.load(restitution=True)
    model.opt.timestep = 1e-4
    data = mujoco.MjData(model)
    speeds = []
    while len(speeds) < 12000:
        mujoco.mj_step(model, data)
        speeds.append(data.qvel[2])
    impact = -min(speeds)
    assert impact == pytest.approx(math.sqrt(2 * 9.81), rel=0.02)
    assert max(speeds) / impact == pytest.approx(restitution, abs=0.05)


def test_rest_and_contact_offsets_are_margin_and_gap(author):
    a = author("Z", 0.01)
    prim = a.gprim("/Robot/c", "Cube", size=20.0)
    a.attrs(prim, {"physxCollision:restOffset": 0.5, "physxCollision:contactOffset": 2.0}, "PhysxCollisionAPI")
    geom = a.load()[0].geom("c")
    assert geom.margin[0] == pytest.approx(0.005)
    assert geom.gap[0] == pytest.approx(0.015)


def test_offsets_of_minus_infinity_are_unset(author):
    a = author()
    prim = a.gprim("/Robot/c", "Cube", size=0.2)
    a.attrs(prim, {"physxCollision:restOffset": -math.inf, "physxCollision:contactOffset": -math.inf})
    a.attrs(prim, {"newton:contactGap": -math.inf})
    geom = a.load()[0].geom("c")
    assert (geom.margin[0], geom.gap[0]) == (0, 0)


def test_mjc_contact_fields_are_mjcfs_own(author):
    a = author()
    prim = a.gprim("/Robot/c", "Cube", size=0.2)
    a.attrs(
        prim,
        {
            "mjc:condim": 4, "mjc:priority": 2, "mjc:margin": 0.003, "mjc:gap": 0.001, "mjc:solmix": 2.5,
            "mjc:solref": [0.01, 0.8], "mjc:solimp": [0.8, 0.9, 0.002], "mjc:group": 4,
            "mjc:friction": [0.7, 0.02, 0.001], "mjc:contype": 6, "mjc:conaffinity": 3,
        },
        "MjcCollisionAPI",
    )  # fmt: skip
    geom = a.load()[0].geom("c")
    assert (geom.condim[0], geom.priority[0], geom.group[0]) == (4, 2, 4)
    assert (geom.contype[0], geom.conaffinity[0]) == (6, 3)
    assert (geom.margin[0], geom.gap[0], geom.solmix[0]) == pytest.approx((0.003, 0.001, 2.5))
    np.testing.assert_allclose(geom.solref, (0.01, 0.8))
    np.testing.assert_allclose(geom.solimp, (0.8, 0.9, 0.002, 0.5, 2))
    np.testing.assert_allclose(geom.friction, (0.7, 0.02, 0.001))


def test_points_collide_as_one_sphere_each(author):
    a = author()
    points = UsdGeom.Points(a.gprim("/Robot/p", "Points"))
    points.CreatePointsAttr([Gf.Vec3f(0, 0, 0), Gf.Vec3f(1, 0, 0)])
    points.CreateWidthsAttr([0.2, 0.4])
    model, _ = a.load()
    assert model.ngeom == 2
    np.testing.assert_allclose(model.geom_size[:, 0], (0.1, 0.2), rtol=1e-6)
    np.testing.assert_allclose(model.geom_pos, [(0, 0, 0), (1, 0, 0)])


def test_a_collider_on_a_prim_without_shape_is_reported(author, notes):
    a = author()
    UsdPhysics.CollisionAPI.Apply(UsdGeom.Xform.Define(a.stage, "/Robot/x").GetPrim())
    a.gprim("/Robot/c", "Cube", size=0.2)
    assert notes(a.load()[1], "/Robot/x")[0]


@pytest.mark.parametrize(
    ("kind", "attrs", "attribute"),
    [
        ("Sphere", {"radius": -1.0}, "radius"),
        ("Sphere", {"radius": math.nan}, "radius"),
        ("Cube", {"size": 0.0}, "size"),
        ("Cylinder", {"height": -2.0}, "height"),
    ],
)
def test_impossible_sizes_are_errors_that_name_prim_and_attribute(author, kind, attrs, attribute):
    a = author()
    a.gprim("/Robot/c", kind, **attrs)
    with pytest.raises(UsdImportError, match=rf"</Robot/c>\.{attribute}"):
        a.load()


@pytest.mark.parametrize(
    ("points", "faces", "attribute"),
    [
        ([(0, 0, 0)], [(0, 1, 2)], "faceVertexIndices"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, -1)], "faceVertexIndices"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 0, 1)], "faceVertexIndices"),
        ([(0, 0, 0), (1, 0, 0), (0, math.nan, 0)], [(0, 1, 2)], "points"),
        ([(0, 0, 0), (1, 0, 0), (0, math.inf, 0)], [(0, 1, 2)], "points"),
        ([], [], "points"),
    ],
)
def test_broken_meshes_are_errors_that_name_prim_and_attribute(author, points, faces, attribute):
    a = author()
    a.mesh("/Robot/c", points, faces)
    with pytest.raises(UsdImportError, match=rf"</Robot/c>\.{attribute}"):
        a.load()


def test_face_counts_that_do_not_add_up_are_an_error(author):
    a = author()
    prim = a.mesh("/Robot/c", BOX_POINTS, BOX_FACES)
    UsdGeom.Mesh(prim).CreateFaceVertexCountsAttr([4, 4])
    with pytest.raises(UsdImportError, match="faceVertexCounts"):
        a.load()


def test_a_prim_scaled_to_nothing_is_an_error(author):
    a = author()
    a.gprim("/Robot/c", "Cube", scale=(1, 0, 1), size=1.0)
    with pytest.raises(UsdImportError, match="</Robot/c>"):
        a.load()
