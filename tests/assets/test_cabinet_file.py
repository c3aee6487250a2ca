"""The cabinet: Isaac Sim's names, standing on the floor, and room for a hand around each handle."""

from pathlib import Path

import cabinet_description as cabinet
import numpy as np
import pytest
import usd_authoring
from panda_description import Box
from pxr import Usd, UsdGeom, UsdPhysics, UsdShade

from lift_lab.utils.assets import ISAAC_NUCLEUS_DIR, resolve_usd_path
from lift_lab_assets.files import ASSETS_USD_DIR

FILE = Path(__file__).resolve().parents[2] / "assets" / "usd" / "cabinet.usda"


@pytest.fixture(scope="module")
def stage() -> Usd.Stage:
    return Usd.Stage.Open(str(FILE))


def extent(stage: Usd.Stage, path: str) -> np.ndarray:
    """Lower and upper corner of what collides under a prim, in the cabinet's frame, shape (2, 3)."""
    cache = UsdGeom.BBoxCache(Usd.TimeCode.Default(), [UsdGeom.Tokens.guide])
    box = cache.ComputeWorldBound(stage.GetPrimAtPath(path)).ComputeAlignedRange()
    return np.array([box.GetMin(), box.GetMax()])


def test_isaac_labs_path_of_the_sektion_cabinet_means_this_file():
    path = f"{ISAAC_NUCLEUS_DIR}/Props/Sektion_Cabinet/sektion_cabinet_instanceable.usd"
    assert resolve_usd_path(path) == ASSETS_USD_DIR / "cabinet.usda"


def test_bodies_and_joints_have_isaac_sims_names(stage):
    bodies = {prim.GetName() for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)}
    assert bodies == {
        *("sektion", "drawer_top", "drawer_bottom", "door_left", "door_right"),
        *("drawer_handle_top", "drawer_handle_bottom"),
    }
    moving = {prim.GetName(): prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.DriveAPI)}
    assert set(moving) == {"drawer_top_joint", "drawer_bottom_joint", "door_left_joint", "door_right_joint"}
    for name in ("drawer_top_joint", "drawer_bottom_joint"):
        joint = UsdPhysics.PrismaticJoint(moving[name])
        assert (joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get()) == (0.0, pytest.approx(0.4))
    for name in ("door_left_joint", "door_right_joint"):
        joint = UsdPhysics.RevoluteJoint(moving[name])
        assert (joint.GetLowerLimitAttr().Get(), joint.GetUpperLimitAttr().Get()) == (0.0, pytest.approx(90.0))


def test_the_cabinet_stands_on_the_floor_when_its_origin_is_40_cm_above_it(stage):
    assert extent(stage, "/Cabinet")[0, 2] == pytest.approx(-0.4, abs=1e-6)


def test_the_handles_bar_is_at_the_point_that_isaac_lab_grasps(stage):
    for side in ("top", "bottom"):
        bar = extent(stage, f"/Cabinet/drawer_handle_{side}/collisions/drawer_handle_{side}_bar")
        frame = np.array(
            UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetPrimAtPath(f"/Cabinet/drawer_handle_{side}"))
        )[3, :3]
        np.testing.assert_allclose(bar.mean(axis=0) - frame, [0.305, 0.0, 0.01], atol=1e-6)
        front = extent(stage, f"/Cabinet/drawer_{side}/collisions/drawer_{side}_front")
        assert bar[0, 0] - front[1, 0] > 0.025  # a finger's 1.85 cm pad has room behind the bar
        assert bar[1, 2] - bar[0, 2] < 0.06  # and an open hand's 8 cm around it
        assert front[0, 2] < bar[0, 2] < bar[1, 2] < front[1, 2]


def test_closed_fronts_leave_gaps_and_cover_the_carcass(stage):
    top, bottom, left, right = (
        extent(stage, path)
        for path in (
            "/Cabinet/drawer_top/collisions/drawer_top_front",
            "/Cabinet/drawer_bottom/collisions/drawer_bottom_front",
            "/Cabinet/door_left/collisions/door_left_panel",
            "/Cabinet/door_right/collisions/door_right_panel",
        )
    )
    for lower, upper in ((bottom, top), (left, bottom), (right, bottom)):
        assert 0.0 < upper[0, 2] - lower[1, 2] < 0.006
    assert 0.0 < left[0, 1] - right[1, 1] < 0.006
    body = extent(stage, "/Cabinet/sektion")
    for front in (top, bottom, left, right):
        assert front[0, 0] == pytest.approx(body[1, 0], abs=1e-6)
    # inside the carcass, a drawer touches no panel
    for side in ("top", "bottom"):
        shelf = extent(stage, "/Cabinet/sektion/collisions/sektion_shelf")
        lid = extent(stage, "/Cabinet/sektion/collisions/sektion_top")
        for part in ("floor", "left", "right", "back"):
            box = extent(stage, f"/Cabinet/drawer_{side}/collisions/drawer_{side}_{part}")
            assert shelf[1, 2] < box[0, 2]
            assert box[1, 2] < lid[0, 2]
            assert np.abs(box[:, 1]).max() < cabinet.WIDTH / 2 - cabinet.BOARD
            assert box[0, 0] > body[0, 0] + cabinet.BOARD


def test_handles_have_the_contact_of_the_finger_pads(stage):
    for prim in stage.Traverse():
        if not prim.HasAPI(UsdPhysics.CollisionAPI):
            continue
        material, _ = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(materialPurpose="physics")
        grasped = "handle" in prim.GetName()
        assert UsdGeom.Imageable(prim).GetPurposeAttr().Get() == "guide"
        assert material.GetPath() == f"/Cabinet/materials/{'handle' if grasped else 'panel'}"
        assert prim.GetAttribute("mjc:condim").Get() == (4 if grasped else 3)


def test_mass_spread_over_boxes_is_that_of_a_cloud_of_points():
    boxes = (Box("a", (0.2, 0.1, 0.3), (0.1, 0.0, -0.2)), Box("b", (0.1, 0.4, 0.1), (-0.3, 0.2, 0.1)))
    link = usd_authoring.link_of_boxes(2.0, boxes)
    grid = (np.stack(np.meshgrid(*[np.arange(20)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + 0.5) / 20 - 0.5
    points = np.concatenate([grid * box.size + box.xyz for box in boxes])
    volumes = np.repeat([np.prod(box.size) for box in boxes], len(grid))
    weights = 2.0 * volumes / volumes.sum()
    com = weights @ points / 2.0
    np.testing.assert_allclose(link.com, com, atol=1e-12)
    arms = points - com
    inertia = np.einsum(
        "p,pij->ij", weights, np.einsum("pk,pk,ij->pij", arms, arms, np.eye(3)) - arms[:, :, None] * arms[:, None]
    )
    expected = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    np.testing.assert_allclose(link.inertia, expected, rtol=3e-3, atol=1e-6)
