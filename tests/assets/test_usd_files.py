"""The committed USD files: built by the script, small, and laid out as Isaac Sim lays out an articulation.

Read with usd-core alone, so that a fault of our importer cannot hide one of the files.
"""

from math import degrees, pi
from pathlib import Path

import build_assets
import numpy as np
import pytest
import usd_authoring
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdShade
from scipy.spatial.transform import Rotation

ARM = [f"panda_link{i}" for i in range(8)]
LINKS = [*ARM, "panda_hand", "panda_leftfinger", "panda_rightfinger"]
JOINTS = [
    *(f"panda_joint{i}" for i in range(1, 8)),
    "panda_hand_joint",
    "panda_finger_joint1",
    "panda_finger_joint2",
]
USD_DIR = Path(__file__).resolve().parents[2] / "assets" / "usd"


@pytest.fixture(scope="module")
def panda() -> Usd.Stage:
    return Usd.Stage.Open(str(USD_DIR / "franka_panda.usda"))


def colliders(stage: Usd.Stage) -> list[Usd.Prim]:
    return [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.CollisionAPI)]


def world_pose(stage: Usd.Stage, path: str) -> np.ndarray:
    return np.array(UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(path))).T


def test_a_file_that_says_something_else_is_told_from_one_whose_last_digits_are_rounded_differently(tmp_path):
    layer = build_assets.build("cube.usda")
    text = layer.ExportToString()
    mass = "float physics:mass = 0.2"
    assert text.count(mass) == 1
    for written, differs in (
        (mass, False),
        (mass + "0000000000000001", False),
        (mass + "0001", True),
        ("float physics:density = 0.2", True),
        ("", True),
    ):
        (tmp_path / "cube.usda").write_text(text.replace(mass, written))
        assert build_assets.differs(layer, tmp_path / "cube.usda") == differs
    assert build_assets.differs(layer, tmp_path / "none.usda")


@pytest.mark.parametrize("name", sorted(build_assets.AUTHORS))
def test_committed_file_says_what_the_script_builds(name):
    assert not build_assets.differs(build_assets.build(name), USD_DIR / name)


def test_check_mode_reports_a_stale_file_and_writes_nothing(tmp_path, capsys):
    assert build_assets.main(["--out", str(tmp_path), "--check"]) == 1
    assert "cube.usda differs" in capsys.readouterr().out
    assert not list(tmp_path.iterdir())


def test_built_files_pass_the_check(tmp_path):
    assert build_assets.main(["--out", str(tmp_path)]) == 0
    assert build_assets.main(["--out", str(tmp_path), "--check"]) == 0


def test_assets_are_small_and_keep_their_notice():
    assert sum(path.stat().st_size for path in USD_DIR.iterdir()) < 3e6
    assert "Copyright 2017 Franka Emika" in (USD_DIR / "NOTICE").read_text()
    assert "Apache License" in (USD_DIR / "LICENSE").read_text()


def test_panda_is_one_articulation_of_eleven_links_directly_under_its_root(panda):
    root = panda.GetDefaultPrim()
    bodies = [prim for prim in panda.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    assert root.GetName() == "Panda"
    assert root.HasAPI(UsdPhysics.ArticulationRootAPI)
    assert root.GetAttribute("physxArticulation:enabledSelfCollisions").Get() is False
    assert sorted(prim.GetName() for prim in bodies) == sorted(LINKS)
    assert all(prim.GetParent() == root for prim in bodies)


def test_each_joint_lies_under_its_parent_link_and_joins_it_to_the_child(panda):
    found = {prim.GetName(): UsdPhysics.Joint(prim) for prim in panda.Traverse() if prim.IsA(UsdPhysics.Joint)}
    assert sorted(found) == sorted([*JOINTS, "root_joint"])
    for name in JOINTS:
        assert found[name].GetBody0Rel().GetTargets() == [found[name].GetPath().GetParentPath()]
    assert found["root_joint"].GetBody0Rel().GetTargets() == []
    assert found["root_joint"].GetBody1Rel().GetTargets() == [
        panda.GetDefaultPrim().GetPath().AppendChild("panda_link0")
    ]


def test_both_joint_frames_agree_with_the_links_poses_at_zero(panda):
    """parent @ frame 0 == child @ frame 1, or the robot would jump when a simulation starts."""
    for prim in panda.Traverse():
        joint = UsdPhysics.Joint(prim)
        if not joint:
            continue
        sides = []
        for body, position, rotation in (
            (joint.GetBody0Rel(), joint.GetLocalPos0Attr(), joint.GetLocalRot0Attr()),
            (joint.GetBody1Rel(), joint.GetLocalPos1Attr(), joint.GetLocalRot1Attr()),
        ):
            frame = Gf.Matrix4d(Gf.Rotation(Gf.Quatd(rotation.Get())), Gf.Vec3d(position.Get()))
            targets = body.GetTargets()
            sides.append((world_pose(panda, targets[0]) if targets else np.eye(4)) @ np.array(frame).T)
        np.testing.assert_allclose(sides[0], sides[1], atol=2e-7, err_msg=prim.GetName())


def test_hand_at_zero_is_where_the_published_kinematics_put_it(panda):
    """At q = 0 the flange looks down at x = 0.088 m, z = 0.333 + 0.316 + 0.384 - 0.107 m."""
    hand = world_pose(panda, "/Panda/panda_hand")
    np.testing.assert_allclose(hand[:3, 3], [0.088, 0, 0.926], atol=1e-12)
    np.testing.assert_allclose(hand[:3, 2], [0, 0, -1], atol=1e-12)


def test_angular_numbers_are_authored_per_degree(panda):
    joint = panda.GetPrimAtPath("/Panda/panda_link3/panda_joint4")
    drive = UsdPhysics.DriveAPI(joint, "angular")
    assert drive.GetStiffnessAttr().Get() == pytest.approx(400 * pi / 180)
    assert drive.GetDampingAttr().Get() == pytest.approx(160 * pi / 180)
    assert drive.GetMaxForceAttr().Get() == 87
    assert UsdPhysics.RevoluteJoint(joint).GetLowerLimitAttr().Get() == pytest.approx(degrees(-3.0718))
    assert joint.GetAttribute("physxJoint:maxJointVelocity").Get() == pytest.approx(degrees(2.175))
    assert joint.GetAttribute("physxJoint:armature").Get() == pytest.approx(0.1)
    finger = UsdPhysics.DriveAPI(panda.GetPrimAtPath("/Panda/panda_hand/panda_finger_joint1"), "linear")
    assert finger.GetStiffnessAttr().Get() == 350
    assert finger.GetMaxForceAttr().Get() == 70


@pytest.mark.parametrize(
    "inertia", [(3.0, 2.0, 4.0, 0.3, -0.2, 0.1), (1.0, 1.0, 2.0, 0.0, 0.0, 0.0), (2, 2, 2, 0.5, 0, 0)]
)
def test_principal_axes_and_moments_reassemble_the_tensor(inertia):
    moments, quat = usd_authoring.principal_inertia(inertia)
    axes = Rotation.from_quat(quat, scalar_first=True).as_matrix()
    xx, yy, zz, xy, xz, yz = inertia
    np.testing.assert_allclose(axes @ np.diag(moments) @ axes.T, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], atol=1e-12)


def test_quaternion_of_any_rotation_is_the_one_with_positive_real_part():
    rotations = Rotation.random(200, rng=np.random.default_rng(0)).as_matrix()
    ours = np.array([usd_authoring.quat_from_rotation(matrix) for matrix in rotations])
    expected = Rotation.from_matrix(rotations).as_quat(canonical=True, scalar_first=True)
    np.testing.assert_allclose(ours, expected, atol=1e-12)


def test_every_collider_is_a_guide_with_a_physics_material():
    for name in ("franka_panda.usda", "cube.usda", "table.usda"):
        stage = Usd.Stage.Open(str(USD_DIR / name))
        shapes = colliders(stage)
        assert shapes
        for prim in shapes:
            material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(materialPurpose="physics")
            assert UsdGeom.Imageable(prim).GetPurposeAttr().Get() == "guide", prim
            assert UsdPhysics.MaterialAPI(material.GetPrim()).GetDynamicFrictionAttr().Get() == 1.0, prim


def test_pads_and_cube_share_the_contact_that_grasping_was_proven_with(panda):
    cube = Usd.Stage.Open(str(USD_DIR / "cube.usda"))
    for prim in (
        panda.GetPrimAtPath("/Panda/panda_leftfinger/collisions/panda_leftfinger_pad"),
        panda.GetPrimAtPath("/Panda/panda_rightfinger/collisions/panda_rightfinger_pad"),
        cube.GetPrimAtPath("/Cube/collisions/cube_collision"),
    ):
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(materialPurpose="physics")
        assert prim.GetAttribute("mjc:condim").Get() == 4
        assert list(prim.GetAttribute("mjc:solref").Get()) == [0.01, 1.0]
        assert list(prim.GetAttribute("mjc:solimp").Get()) == [0.95, 0.99, 0.001]
        assert material.GetPrim().GetAttribute("mjc:torsionalfriction").Get() == 0.02
        assert material.GetPrim().GetAttribute("mjc:rollingfriction").Get() == 0.0001


def test_closed_finger_pads_meet_in_the_middle_of_the_hand(panda):
    """Each pad's inner face is within 0.1 mm of its finger's origin plane, the left one looking at -y."""
    box = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.guide])
    for side, sign in (("left", 1), ("right", -1)):
        finger = panda.GetPrimAtPath(f"/Panda/panda_{side}finger")
        pad = finger.GetPrimAtPath(f"collisions/panda_{side}finger_pad")
        extent = box.ComputeRelativeBound(pad, finger).ComputeAlignedRange()
        inner, outer = sorted((sign * extent.GetMin()[1], sign * extent.GetMax()[1]))
        assert inner == pytest.approx(0.0, abs=1e-4)
        assert outer == pytest.approx(0.0152, abs=1e-4)
        assert extent.GetMax()[2] == pytest.approx(0.0535, abs=1e-6)


def test_finger_colliders_variant_brings_the_exact_four_boxes(panda):
    stage = Usd.Stage.Open(str(USD_DIR / "franka_panda.usda"))
    fingers = lambda: [p for p in colliders(stage) if "finger" in p.GetName()]  # noqa: E731
    assert len(fingers()) == 2 * 2
    stage.GetDefaultPrim().GetVariantSet("FingerColliders").SetVariantSelection("full")
    assert len(fingers()) == 2 * 4
    right = world_pose(stage, "/Panda/panda_rightfinger/collisions/panda_rightfinger_diagonal")
    finger = world_pose(stage, "/Panda/panda_rightfinger")
    expected = Rotation.from_euler("z", pi) * Rotation.from_euler("x", pi / 6)
    local = np.linalg.inv(finger) @ right
    np.testing.assert_allclose(local[:3, 3], [0, -0.0159, 0.02835], atol=1e-9)
    np.testing.assert_allclose(local[:3, :3] / [0.0175, 0.007, 0.0235], expected.as_matrix(), atol=1e-9)


def test_finger_mimic_variant_ties_the_second_finger_to_the_first():
    stage = Usd.Stage.Open(str(USD_DIR / "franka_panda.usda"))
    joint = stage.GetPrimAtPath("/Panda/panda_hand/panda_finger_joint2")
    assert not any(s.startswith("PhysxMimic") for s in joint.GetPrimTypeInfo().GetAppliedAPISchemas())
    stage.GetDefaultPrim().GetVariantSet("FingerMimic").SetVariantSelection("on")
    assert "PhysxMimicJointAPI:rotX" in joint.GetPrimTypeInfo().GetAppliedAPISchemas()
    # PhysX holds q2 + gearing q1 + offset = 0.
    assert joint.GetAttribute("physxMimicJoint:rotX:gearing").Get() == -1
    assert joint.GetAttribute("physxMimicJoint:rotX:offset").Get() == 0
    leader = joint.GetRelationship("physxMimicJoint:rotX:referenceJoint").GetTargets()
    assert leader == ["/Panda/panda_hand/panda_finger_joint1"]


def test_joint_friction_variant_brings_the_identified_values():
    stage = Usd.Stage.Open(str(USD_DIR / "franka_panda.usda"))
    joint = stage.GetPrimAtPath("/Panda/panda_link6/panda_joint7")
    assert not joint.GetAttribute("mjc:frictionloss").IsValid()
    stage.GetDefaultPrim().GetVariantSet("JointFriction").SetVariantSelection("identified")
    assert joint.GetAttribute("mjc:frictionloss").Get() == 1.211


def test_visuals_are_instances_and_cover_every_link(panda):
    for link in LINKS:
        visuals = panda.GetPrimAtPath(f"/Panda/{link}/visuals")
        assert visuals.IsInstance(), link
        meshes = visuals.GetFilteredChildren(Usd.TraverseInstanceProxies())
        assert meshes, link
        for prim in meshes:
            mesh = UsdGeom.Mesh(prim)
            points = np.array(mesh.GetPointsAttr().Get())
            faces = np.array(mesh.GetFaceVertexIndicesAttr().Get())
            assert np.isfinite(points).all()
            assert set(mesh.GetFaceVertexCountsAttr().Get()) == {3}
            assert np.array_equal(np.unique(faces), np.arange(len(points)))


def test_visuals_have_the_size_of_the_robot(panda):
    """Outer measures of the maker's meshes, which an edge collapse may change by a millimetre or two."""
    for link, low, high in (
        ("panda_link0", (-0.154, -0.095, 0.0), (0.0715, 0.095, 0.14)),
        ("panda_hand", (-0.0315, -0.104, -0.026), (0.0315, 0.1006, 0.066)),
        ("panda_leftfinger", (-0.0105, 0.0, 0.0), (0.0105, 0.0263, 0.0539)),
        ("panda_rightfinger", (-0.0105, -0.0263, 0.0), (0.0105, 0.0, 0.0539)),
    ):
        visuals = panda.GetPrimAtPath(f"/Panda/{link}/visuals")
        meshes = visuals.GetFilteredChildren(Usd.TraverseInstanceProxies())
        points = np.concatenate([UsdGeom.Mesh(prim).GetPointsAttr().Get() for prim in meshes])
        np.testing.assert_allclose(points.min(axis=0), low, atol=3e-3, err_msg=link)
        np.testing.assert_allclose(points.max(axis=0), high, atol=3e-3, err_msg=link)


def test_cube_never_lifts_its_centre_above_four_centimetres_by_tumbling():
    stage = Usd.Stage.Open(str(USD_DIR / "cube.usda"))
    edge = np.array(stage.GetPrimAtPath("/Cube/collisions/cube_collision").GetAttribute("xformOp:scale").Get())
    np.testing.assert_allclose(edge, 0.04)
    assert np.linalg.norm(edge) / 2 < 0.04
    assert UsdPhysics.MassAPI(stage.GetDefaultPrim()).GetMassAttr().Get() == pytest.approx(0.2)


def test_table_top_is_at_zero_and_carries_the_robots_base(panda):
    """The lift task puts the table at (0.5, 0, 0), turned by 90 degrees about z; the robot stands at the
    origin."""
    stage = Usd.Stage.Open(str(USD_DIR / "table.usda"))
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.guide, UsdGeom.Tokens.default_])
    placed = Gf.Matrix4d(Gf.Rotation(Gf.Vec3d(0, 0, 1), 90), Gf.Vec3d(0.5, 0, 0))
    top = cache.ComputeWorldBound(stage.GetPrimAtPath("/Table/collisions/table_collision"))
    top.Transform(placed)
    extent = top.ComputeAlignedRange()
    whole = cache.ComputeWorldBound(stage.GetDefaultPrim()).ComputeAlignedRange()
    base = cache.ComputeWorldBound(panda.GetPrimAtPath("/Panda/panda_link0/visuals")).ComputeAlignedRange()
    assert extent.GetMax()[2] == pytest.approx(0.0, abs=1e-9)
    assert whole.GetMax()[2] == pytest.approx(0.0, abs=1e-9)
    assert whole.GetMin()[2] == pytest.approx(-1.05, abs=1e-9)
    assert extent.GetMin()[0] < base.GetMin()[0] < base.GetMax()[0] < extent.GetMax()[0]
    assert extent.GetMin()[1] < base.GetMin()[1] < base.GetMax()[1] < extent.GetMax()[1]


def test_moving_links_of_the_arm_clear_the_table_at_zero(panda):
    """Link 1 stands on the base for ever: a collider of it below z = 0 would touch the table in every
    step."""
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.guide])
    for link in LINKS[1:]:
        bound = cache.ComputeWorldBound(panda.GetPrimAtPath(f"/Panda/{link}/collisions")).ComputeAlignedRange()
        assert bound.GetMin()[2] > 0.005, link


def test_cartpole_has_isaac_labs_names_and_a_pole_without_limits():
    stage = Usd.Stage.Open(str(USD_DIR / "cartpole.usda"))
    bodies = [prim.GetName() for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    assert bodies == ["slider", "cart", "pole"]
    rail = UsdPhysics.PrismaticJoint(stage.GetPrimAtPath("/Cartpole/slider/slider_to_cart"))
    hinge = UsdPhysics.RevoluteJoint(stage.GetPrimAtPath("/Cartpole/cart/cart_to_pole"))
    assert (rail.GetAxisAttr().Get(), hinge.GetAxisAttr().Get()) == ("Y", "X")
    assert (rail.GetLowerLimitAttr().Get(), rail.GetUpperLimitAttr().Get()) == (-4, 4)
    assert hinge.GetUpperLimitAttr().Get() == float("inf")
    assert np.isinf(hinge.GetLowerLimitAttr().Get())
