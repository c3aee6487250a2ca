"""Sampling, scaling and camera geometry."""

import math

import numpy as np
import pytest
import torch
from scipy import stats
from scipy.spatial.transform import Rotation

import lift_lab.utils.math as math_utils

M = 20000


@pytest.fixture(autouse=True)
def _seed():
    torch.manual_seed(0)


def test_scaling_maps_the_range_to_minus_one_and_one_and_back():
    lower, upper = torch.tensor([-2.0, 0.0]), torch.tensor([2.0, 10.0])
    x = torch.tensor([[-2.0, 0.0], [0.0, 5.0], [2.0, 10.0]])
    scaled = math_utils.scale_transform(x, lower, upper)
    assert scaled.tolist() == [[-1.0, -1.0], [0.0, 0.0], [1.0, 1.0]]
    torch.testing.assert_close(math_utils.unscale_transform(scaled, lower, upper), x)
    assert math_utils.saturate(2.0 * x, lower, upper).tolist() == [[-2.0, 0.0], [0.0, 10.0], [2.0, 10.0]]


def test_vectors_are_normalised_and_zero_stays_zero():
    x = torch.tensor([[3.0, 4.0, 0.0], [0.0, 0.0, 0.0]])
    torch.testing.assert_close(math_utils.normalize(x), torch.tensor([[0.6, 0.8, 0.0], [0.0, 0.0, 0.0]]))


def test_angles_wrap_to_pi_and_odd_multiples_keep_their_sign():
    angles = torch.tensor([0.0, 3.0, 4.0, -4.0, 7.0, math.pi, -math.pi, 3 * math.pi], dtype=torch.float64)
    expected = [0.0, 3.0, 4.0 - 2 * math.pi, 2 * math.pi - 4.0, 7.0 - 2 * math.pi, math.pi, -math.pi, math.pi]
    torch.testing.assert_close(math_utils.wrap_to_pi(angles), torch.tensor(expected, dtype=torch.float64))


def test_copysign_takes_the_sign_of_the_tensor():
    assert math_utils.copysign(-2.0, torch.tensor([1.0, -3.0, 0.0])).tolist() == [2.0, -2.0, 2.0]


@pytest.mark.parametrize(
    ("sample", "cdf"),
    [
        (lambda: math_utils.sample_uniform(-1.0, 3.0, M, "cpu"), stats.uniform(-1, 4).cdf),
        (lambda: math_utils.sample_log_uniform(0.1, 10.0, M, "cpu"), stats.loguniform(0.1, 10).cdf),
        (lambda: math_utils.sample_gaussian(1.0, 2.0, M, "cpu"), stats.norm(1, 2).cdf),
        (lambda: math_utils.sample_triangle(0.0, 2.0, M, "cpu"), lambda x: (1 + np.sign(x - 1) * (x - 1) ** 2) / 2),
    ],
    ids=["uniform", "log_uniform", "gaussian", "triangle"],
)
def test_samples_follow_their_distribution(sample, cdf):
    assert stats.kstest(sample().numpy(), cdf).pvalue > 0.01


def test_bounds_may_be_tensors():
    lower, upper = torch.tensor([0.0, 10.0]), torch.tensor([1.0, 20.0])
    x = math_utils.sample_uniform(lower, upper, (1000, 2), "cpu")
    assert bool(((x >= lower) & (x < upper)).all())
    x = math_utils.sample_gaussian(torch.tensor([0.0, 100.0]), torch.tensor([1.0, 1.0]), (1000, 2), "cpu")
    torch.testing.assert_close(x.mean(dim=0), torch.tensor([0.0, 100.0]), atol=0.2, rtol=0)


def test_points_lie_on_the_shell_of_the_cylinder():
    points = math_utils.sample_cylinder(0.5, (0.1, 0.2), (10, 100), "cpu")
    assert points.shape == (10, 100, 3)
    torch.testing.assert_close(points[..., :2].norm(dim=-1), torch.full((10, 100), 0.5))
    assert 0.1 <= float(points[..., 2].min()) < float(points[..., 2].max()) <= 0.2


def test_random_orientations_turn_a_vector_anywhere():
    quat = math_utils.random_orientation(M, "cpu")
    z = math_utils.quat_apply(quat, torch.tensor([1.0, 0.0, 0.0]))[:, 2]
    assert stats.kstest(z.numpy(), stats.uniform(-1, 2).cdf).pvalue > 0.01  # Archimedes: z is uniform on a sphere


def test_random_yaw_turns_about_z_by_any_angle():
    quat = math_utils.random_yaw_orientation(M, "cpu")
    assert torch.equal(quat[:, 1:3], torch.zeros(M, 2))
    yaw = math_utils.euler_xyz_from_quat(quat)[2]
    assert stats.kstest(yaw.numpy(), stats.uniform(-math.pi, 2 * math.pi).cdf).pvalue > 0.01


def test_the_default_orientation_is_the_identity():
    assert math_utils.default_orientation(2, "cpu").tolist() == [[1.0, 0.0, 0.0, 0.0]] * 2


def test_random_poses_are_rigid_and_bounded():
    pose = math_utils.generate_random_transformation_matrix(pos_boundary=0.5, rot_boundary=0.1)
    rot = pose[:3, :3]
    torch.testing.assert_close(rot @ rot.T, torch.eye(3))
    assert float(pose[:3, 3].abs().max()) <= 0.5
    assert math.acos(float((rot.trace() - 1) / 2)) <= 0.3


def test_a_random_rotation_has_angles_below_its_bound_and_a_random_translation_fills_its_cube():
    for _ in range(20):
        rot = math_utils.generate_random_rotation(rot_boundary=0.3)
        torch.testing.assert_close(rot @ rot.T, torch.eye(3))
        angles = Rotation.from_matrix(rot.numpy()).as_euler("ZYX")  # Rz Ry Rx
        assert ((angles >= -1e-6) & (angles < 0.3)).all()
    points = torch.stack([math_utils.generate_random_translation(2.0) for _ in range(500)])
    assert stats.kstest(points.flatten().numpy(), stats.uniform(-2.0, 4.0).cdf).pvalue > 0.01


##
# Camera
##

AXES = {  # forward and up of each convention, in its own frame
    "opengl": ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0)),
    "ros": ((0.0, 0.0, 1.0), (0.0, -1.0, 0.0)),
    "world": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
}


@pytest.mark.parametrize("origin", AXES)
@pytest.mark.parametrize("target", AXES)
def test_a_camera_looks_the_same_way_in_every_convention(origin, target):
    quat = math_utils.random_orientation(8, "cpu")
    converted = math_utils.convert_camera_frame_orientation_convention(quat, origin, target)
    for before, after in zip(AXES[origin], AXES[target], strict=True):
        torch.testing.assert_close(
            math_utils.quat_apply(converted, torch.tensor(after)),
            math_utils.quat_apply(quat, torch.tensor(before)),
            atol=1e-5,
            rtol=0,
        )
    with pytest.raises(ValueError, match="unknown camera convention 'usd'"):
        math_utils.convert_camera_frame_orientation_convention(quat, "usd", target)  # type: ignore[arg-type]


@pytest.mark.parametrize("up_axis", ["Y", "Z"])
def test_the_view_matrix_looks_at_the_target_with_up_up(up_axis):
    eyes, targets = torch.randn(16, 3), torch.randn(1, 3)
    rot = math_utils.create_rotation_matrix_from_view(eyes, targets, up_axis)
    torch.testing.assert_close(-rot[:, :, 2], torch.nn.functional.normalize(targets - eyes, dim=-1))
    torch.testing.assert_close(rot @ rot.transpose(1, 2), torch.eye(3).expand(16, 3, 3), atol=1e-5, rtol=0)
    torch.testing.assert_close(torch.linalg.det(rot), torch.ones(16))
    up = 1 if up_axis == "Y" else 2
    assert bool((rot[:, up, 1] > 0).all())
    torch.testing.assert_close(rot[:, up, 0], torch.zeros(16), atol=1e-6, rtol=0)


def test_looking_straight_down_gives_a_rotation():
    rot = math_utils.create_rotation_matrix_from_view(torch.tensor([[0.0, 0.0, 1.0]]), torch.zeros(1, 3))
    torch.testing.assert_close(rot[0], torch.eye(3))


K = torch.tensor([[100.0, 0.0, 4.0], [0.0, 120.0, 3.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("shape", [(6, 8), (6, 8, 1), (2, 6, 8), (2, 6, 8, 1)])
@pytest.mark.parametrize("is_ortho", [True, False])
def test_unprojected_depth_projects_back_to_its_pixels(shape, is_ortho):
    depth = torch.rand(shape) + 1.0
    points = math_utils.unproject_depth(depth, K, is_ortho=is_ortho)
    pixels = math_utils.project_points(points, K)
    v, u = torch.meshgrid(torch.arange(6.0), torch.arange(8.0), indexing="ij")
    images = depth.reshape(-1, 6, 8)
    pixels = pixels.reshape(-1, 48, 3)
    for image, pixel, point in zip(images, pixels, points.reshape(-1, 48, 3), strict=True):
        torch.testing.assert_close(pixel[:, 0], u.T.flatten(), atol=1e-4, rtol=0)
        torch.testing.assert_close(pixel[:, 1], v.T.flatten(), atol=1e-4, rtol=0)
        measured = point[:, 2] if is_ortho else point.norm(dim=-1)
        torch.testing.assert_close(measured, image.T.flatten())


def test_perspective_depth_of_a_plane_becomes_constant():
    v, u = torch.meshgrid(torch.arange(6.0), torch.arange(8.0), indexing="ij")
    rays = torch.stack(((u - 4.0) / 100.0, (v - 3.0) / 120.0, torch.ones_like(u)), dim=-1)
    depth = 2.0 * rays.norm(dim=-1)
    torch.testing.assert_close(math_utils.orthogonalize_perspective_depth(depth, K), torch.full((6, 8), 2.0))


def test_wrong_shapes_of_images_and_points_are_refused():
    with pytest.raises(ValueError, match="expected depth"):
        math_utils.unproject_depth(torch.ones(6), K)
    with pytest.raises(ValueError, match="expected intrinsics"):
        math_utils.orthogonalize_perspective_depth(torch.ones(6, 8), K[0])
    with pytest.raises(ValueError, match="expected points"):
        math_utils.project_points(torch.ones(3), K)
