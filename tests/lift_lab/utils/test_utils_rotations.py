"""Rotations and frames against scipy, 4x4 matrices and closed forms."""

import math

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation, Slerp

import lift_lab.utils.math as math_utils

N = 64


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def rotations() -> Rotation:
    return Rotation.random(N, random_state=1)


def wxyz(rotation: Rotation) -> torch.Tensor:
    return torch.as_tensor(np.roll(rotation.as_quat(), 1, axis=-1))


def scipy_of(quat: torch.Tensor) -> Rotation:
    return Rotation.from_quat(np.roll(quat.numpy(), -1, axis=-1))


def tensor(array) -> torch.Tensor:
    return torch.as_tensor(np.array(array, dtype=np.float64))


def assert_same_rotation(quat: torch.Tensor, rotation: Rotation) -> None:
    np.testing.assert_allclose((scipy_of(quat).inv() * rotation).magnitude(), 0.0, atol=1e-7)
    torch.testing.assert_close(quat.norm(dim=-1), torch.ones_like(quat[..., 0]))


def matrices(pos: torch.Tensor, rotation: Rotation) -> np.ndarray:
    pose = np.tile(np.eye(4), (len(pos), 1, 1))
    pose[:, :3, :3] = rotation.as_matrix()
    pose[:, :3, 3] = pos.numpy()
    return pose


##
# Quaternions
##


def test_product_and_inverse_of_quaternions_compose_rotations(rotations):
    other = Rotation.random(N, random_state=2)
    assert_same_rotation(math_utils.quat_mul(wxyz(rotations), wxyz(other)), rotations * other)
    assert_same_rotation(math_utils.quat_inv(wxyz(rotations)), rotations.inv())
    assert_same_rotation(math_utils.quat_conjugate(wxyz(rotations)), rotations.inv())
    identity = math_utils.quat_mul(3.0 * wxyz(rotations), math_utils.quat_inv(3.0 * wxyz(rotations)))
    torch.testing.assert_close(identity, tensor([[1.0, 0, 0, 0]]).expand(N, 4))


def test_the_product_keeps_the_algebra_of_i_j_k():
    one, i, j, k = torch.eye(4).unbind()
    assert torch.equal(math_utils.quat_mul(i, j), k)
    assert torch.equal(math_utils.quat_mul(j, k), i)
    assert torch.equal(math_utils.quat_mul(k, i), j)
    assert torch.equal(math_utils.quat_mul(i, i), -one)


def test_vectors_are_rotated_forth_and_back(rotations, rng):
    vectors = tensor(rng.normal(size=(N, 3)))
    torch.testing.assert_close(math_utils.quat_apply(wxyz(rotations), vectors), tensor(rotations.apply(vectors)))
    inverse = tensor(rotations.apply(vectors, inverse=True))
    torch.testing.assert_close(math_utils.quat_apply_inverse(wxyz(rotations), vectors), inverse)
    assert math_utils.quat_rotate_inverse is math_utils.quat_apply_inverse


def test_one_rotation_turns_many_vectors_and_many_rotations_one_vector(rotations, rng):
    vectors = tensor(rng.normal(size=(5, N, 3)))
    expected = tensor(np.stack([rotations.apply(v) for v in vectors.numpy()]))
    torch.testing.assert_close(math_utils.quat_apply(wxyz(rotations), vectors), expected)
    up = torch.tensor([0.0, 0.0, 1.0], dtype=torch.float64)
    torch.testing.assert_close(math_utils.quat_apply(wxyz(rotations), up), tensor(rotations.as_matrix()[:, :, 2]))


def test_matrices_and_quaternions_convert_into_each_other(rotations):
    torch.testing.assert_close(math_utils.matrix_from_quat(2.0 * wxyz(rotations)), tensor(rotations.as_matrix()))
    assert_same_rotation(math_utils.quat_from_matrix(tensor(rotations.as_matrix())), rotations)


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_half_turns_survive_the_way_through_a_matrix(axis):
    for angle in (math.pi, math.pi - 1e-4, -math.pi + 1e-4):
        rotation = Rotation.from_euler(axis, [angle])
        assert_same_rotation(math_utils.quat_from_matrix(tensor(rotation.as_matrix())), rotation)


def test_a_matrix_of_another_shape_is_refused():
    with pytest.raises(ValueError, match=r"expected shape \(\.\.\., 3, 3\), got \(4, 4\)"):
        math_utils.quat_from_matrix(torch.eye(4))


def test_euler_angles_are_roll_pitch_yaw_about_fixed_axes(rng):
    angles = rng.uniform(-1.5, 1.5, size=(N, 3))
    rotation = Rotation.from_euler("xyz", angles)
    quat = math_utils.quat_from_euler_xyz(*tensor(angles).unbind(-1))
    assert_same_rotation(quat, rotation)
    torch.testing.assert_close(torch.stack(math_utils.euler_xyz_from_quat(quat), dim=-1), tensor(angles))
    wrapped = torch.stack(math_utils.euler_xyz_from_quat(quat, wrap_to_2pi=True), dim=-1)
    torch.testing.assert_close(wrapped, tensor(angles % (2 * math.pi)))


def test_pitch_at_the_pole_is_a_right_angle_and_not_nan():
    quat = math_utils.quat_from_euler_xyz(*torch.tensor([0.0, math.pi / 2, 0.0]).unbind())
    assert float(math_utils.euler_xyz_from_quat(1.000001 * quat[None])[1]) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("convention", ["XYZ", "ZYX", "ZXZ", "YXY"])
def test_matrices_of_euler_angles_are_intrinsic(convention, rng):
    angles = rng.uniform(-3, 3, size=(N, 3))
    expected = tensor(Rotation.from_euler(convention, angles).as_matrix())
    torch.testing.assert_close(math_utils.matrix_from_euler(tensor(angles), convention), expected)


@pytest.mark.parametrize("convention", ["XXY", "XY", "ABC"])
def test_an_euler_convention_without_sense_is_refused(convention):
    with pytest.raises(ValueError, match=convention):
        math_utils.matrix_from_euler(torch.zeros(3), convention)


def test_axis_angle_vectors_convert_both_ways(rotations):
    torch.testing.assert_close(math_utils.axis_angle_from_quat(wxyz(rotations)), tensor(rotations.as_rotvec()))
    torch.testing.assert_close(math_utils.axis_angle_from_quat(-wxyz(rotations)), tensor(rotations.as_rotvec()))
    vectors = tensor(rotations.as_rotvec())
    assert_same_rotation(math_utils.quat_from_angle_axis(vectors.norm(dim=-1), 5.0 * vectors), rotations)


def test_tiny_and_zero_rotations_have_exact_axis_angle_vectors():
    vectors = torch.tensor([[0.0, 0.0, 0.0], [1e-7, 0.0, 0.0], [0.0, 1e-4, 0.0]], dtype=torch.float64)
    torch.testing.assert_close(math_utils.axis_angle_from_quat(wxyz(Rotation.from_rotvec(vectors.numpy()))), vectors)


def test_box_minus_and_box_plus_undo_each_other(rotations):
    other = Rotation.random(N, random_state=3)
    delta = math_utils.quat_box_minus(wxyz(other), wxyz(rotations))
    torch.testing.assert_close(delta, tensor((other * rotations.inv()).as_rotvec()))
    assert_same_rotation(math_utils.quat_box_plus(wxyz(rotations), delta), other)
    unmoved = math_utils.quat_box_plus(wxyz(rotations), torch.zeros(N, 3, dtype=torch.float64))
    np.testing.assert_allclose((scipy_of(unmoved).inv() * rotations).magnitude(), 0.0, atol=1e-5)


def test_the_error_magnitude_is_the_angle_between_orientations(rotations):
    other = Rotation.random(N, random_state=4)
    expected = tensor((other * rotations.inv()).magnitude())
    torch.testing.assert_close(math_utils.quat_error_magnitude(wxyz(other), -wxyz(rotations)), expected)


def test_unique_quaternions_have_a_real_part_that_is_not_negative(rotations):
    quat = math_utils.quat_unique(-wxyz(rotations))
    assert bool((quat[:, 0] >= 0).all())
    assert_same_rotation(quat, rotations)


def test_yaw_is_what_is_left_without_roll_and_pitch(rng):
    angles = tensor(rng.uniform(-1.5, 1.5, size=(N, 3)))
    yaw = Rotation.from_euler("z", angles[:, 2:].numpy())
    quat = math_utils.quat_from_euler_xyz(*angles.unbind(-1))
    assert_same_rotation(math_utils.yaw_quat(quat), yaw)
    vectors = tensor(rng.normal(size=(N, 3)))
    torch.testing.assert_close(math_utils.quat_apply_yaw(quat, vectors), tensor(yaw.apply(vectors)))


def test_the_order_of_components_is_converted_for_torch_and_numpy():
    for quat in (torch.tensor([1.0, 2.0, 3.0, 4.0]), np.array([1.0, 2.0, 3.0, 4.0])):
        assert math_utils.convert_quat(quat, to="xyzw").tolist() == [2.0, 3.0, 4.0, 1.0]
        assert math_utils.convert_quat(quat, to="wxyz").tolist() == [4.0, 1.0, 2.0, 3.0]
    with pytest.raises(ValueError, match="'xyzw' or 'wxyz'"):
        math_utils.convert_quat(torch.ones(4), to="xwyz")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="shape"):
        math_utils.convert_quat(torch.ones(3))


def test_the_skew_symmetric_matrix_is_the_cross_product(rng):
    a, b = tensor(rng.normal(size=(2, N, 3)))
    product = (math_utils.skew_symmetric_matrix(a) @ b.unsqueeze(-1)).squeeze(-1)
    torch.testing.assert_close(product, torch.linalg.cross(a, b))
    assert math_utils.skew_symmetric_matrix(a[0]).shape == (1, 3, 3)


##
# Frames
##


def test_frames_combine_as_matrices_multiply(rotations, rng):
    other = Rotation.random(N, random_state=5)
    t01, t12 = tensor(rng.normal(size=(2, N, 3)))
    t02, q02 = math_utils.combine_frame_transforms(t01, wxyz(rotations), t12, wxyz(other))
    expected = matrices(t01, rotations) @ matrices(t12, other)
    torch.testing.assert_close(t02, tensor(expected[:, :3, 3]))
    torch.testing.assert_close(math_utils.matrix_from_quat(q02), tensor(expected[:, :3, :3]))


def test_frames_subtract_as_matrices_divide(rotations, rng):
    other = Rotation.random(N, random_state=6)
    t01, t02 = tensor(rng.normal(size=(2, N, 3)))
    t12, q12 = math_utils.subtract_frame_transforms(t01, wxyz(rotations), t02, wxyz(other))
    expected = np.linalg.inv(matrices(t01, rotations)) @ matrices(t02, other)
    torch.testing.assert_close(t12, tensor(expected[:, :3, 3]))
    torch.testing.assert_close(math_utils.matrix_from_quat(q12), tensor(expected[:, :3, :3]))


def test_a_frame_left_out_is_the_identity(rotations, rng):
    t01 = tensor(rng.normal(size=(N, 3)))
    same = math_utils.combine_frame_transforms(t01, wxyz(rotations))
    assert torch.equal(same[0], t01)
    assert torch.equal(same[1], wxyz(rotations))
    t10, q10 = math_utils.subtract_frame_transforms(t01, wxyz(rotations))
    back = math_utils.combine_frame_transforms(t01, wxyz(rotations), t10, q10)
    assert math_utils.is_identity_pose(*back)
    assert not math_utils.is_identity_pose(t01, wxyz(rotations))


def test_twists_move_between_frames_of_one_rigid_body(rotations, rng):
    v0, w0, t01 = tensor(rng.normal(size=(3, N, 3)))
    v1, w1 = math_utils.rigid_body_twist_transform(v0, w0, t01, wxyz(rotations))
    torch.testing.assert_close(w1, tensor(rotations.inv().apply(w0)))
    torch.testing.assert_close(v1, tensor(rotations.inv().apply(v0.numpy() + np.cross(w0.numpy(), t01.numpy()))))


def test_the_pose_error_leads_from_source_to_target(rotations, rng):
    other = Rotation.random(N, random_state=7)
    t01, t02 = tensor(rng.normal(size=(2, N, 3)))
    pos_error, rot_error = math_utils.compute_pose_error(t01, wxyz(rotations), t02, wxyz(other))
    torch.testing.assert_close(pos_error, t02 - t01)
    torch.testing.assert_close(rot_error, tensor((other * rotations.inv()).as_rotvec()))
    delta = torch.cat((pos_error, rot_error), dim=-1)
    moved_pos, moved_rot = math_utils.apply_delta_pose(t01, wxyz(rotations), delta)
    torch.testing.assert_close(moved_pos, t02)
    assert_same_rotation(moved_rot, other)
    _, quat_error = math_utils.compute_pose_error(t01, wxyz(rotations), t02, wxyz(other), rot_error_type="quat")
    assert_same_rotation(quat_error, other * rotations.inv())
    with pytest.raises(ValueError, match="'quat' or 'axis_angle'"):
        math_utils.compute_pose_error(t01, t02, t01, t02, rot_error_type="euler")  # type: ignore[arg-type]


def test_a_delta_pose_without_rotation_leaves_the_orientation_untouched(rotations):
    pos = torch.zeros(N, 3, dtype=torch.float64)
    _, rot = math_utils.apply_delta_pose(pos, wxyz(rotations), torch.zeros(N, 6, dtype=torch.float64))
    assert torch.equal(rot, wxyz(rotations))


def test_points_are_rotated_and_then_moved(rotations, rng):
    points, pos = tensor(rng.normal(size=(N, 7, 3))), tensor(rng.normal(size=(N, 3)))
    expected = np.einsum("nij,npj->npi", rotations.as_matrix(), points.numpy()) + pos.numpy()[:, None]
    torch.testing.assert_close(math_utils.transform_points(points, pos, wxyz(rotations)), tensor(expected))
    one = math_utils.transform_points(points[0], pos[0], wxyz(rotations)[0])
    torch.testing.assert_close(one, tensor(expected[0]))
    assert math_utils.transform_points(points[0], quat=wxyz(rotations)).shape == (N, 7, 3)
    untouched = math_utils.transform_points(points)
    assert torch.equal(untouched, points)
    assert untouched is not points
    with pytest.raises(ValueError, match="points of shape"):
        math_utils.transform_points(points[0, 0])


##
# Pose matrices and interpolation
##


def test_pose_matrices_are_made_taken_apart_and_inverted(rotations, rng):
    pos = tensor(rng.normal(size=(N, 3)))
    pose = math_utils.make_pose(pos, tensor(rotations.as_matrix()))
    torch.testing.assert_close(pose, tensor(matrices(pos, rotations)))
    assert torch.equal(math_utils.unmake_pose(pose)[0], pos)
    torch.testing.assert_close(math_utils.pose_inv(pose), torch.linalg.inv(pose))
    torch.testing.assert_close(math_utils.pose_in_A_to_pose_in_B(pose[1:], pose[:1]), pose[0] @ pose[1:])


def test_poses_keep_their_place_relative_to_the_frame_that_moves():
    poses = torch.stack([math_utils.generate_random_transformation_matrix() for _ in range(4)]).double()
    frame_a, frame_b = (math_utils.generate_random_transformation_matrix().double() for _ in range(2))
    moved = math_utils.transform_poses_from_frame_A_to_frame_B(poses, frame_a, frame_b)
    torch.testing.assert_close(torch.linalg.inv(frame_a) @ moved, torch.linalg.inv(frame_b) @ poses)


def test_slerp_follows_the_shorter_arc(rotations):
    other = Rotation.random(N, random_state=8)
    for tau in (0.0, 0.3, 1.0):
        expected = Rotation.concatenate(
            [Slerp([0, 1], Rotation.concatenate([a, b]))(tau) for a, b in zip(rotations, other, strict=True)]
        )
        assert_same_rotation(math_utils.quat_slerp(wxyz(rotations), -wxyz(other), tau), expected)
    q = wxyz(rotations)
    torch.testing.assert_close(math_utils.quat_slerp(q, q, 0.5), q)


@pytest.mark.parametrize("axis_angle", [True, False])
def test_rotations_are_interpolated_at_a_constant_rate(axis_angle):
    ends = Rotation.random(2, random_state=9)
    first, last = tensor(ends.as_matrix())
    steps = math_utils.interpolate_rotations(first, last, 5, axis_angle=axis_angle)
    expected = Slerp([0, 1], ends)(np.linspace(0, 1, 6)).as_matrix()
    torch.testing.assert_close(steps, tensor(expected))


def test_poses_are_interpolated_by_number_or_by_distance():
    pose_1, pose_2 = torch.eye(4), torch.eye(4)
    pose_2[0, 3] = 1.0
    poses, number = math_utils.interpolate_poses(pose_1, pose_2, num_steps=3)
    assert number == 3
    torch.testing.assert_close(poses[:, 0, 3], torch.tensor([0.0, 0.25, 0.5, 0.75, 1.0]))
    assert math_utils.interpolate_poses(pose_1, pose_2, step_size=0.3)[1] == 4
    ends, number = math_utils.interpolate_poses(pose_1, pose_2, num_steps=0)
    assert number == 0
    assert torch.equal(ends, torch.stack((pose_1, pose_2)))
    moved, _ = math_utils.interpolate_poses(pose_1, pose_2, num_steps=3, perturb=True)
    assert float((moved[1:-1, 0, 3] - poses[1:-1, 0, 3]).abs().max()) <= 0.125
    assert torch.equal(moved[[0, -1]], poses[[0, -1]])
    with pytest.raises(ValueError, match="one of num_steps and step_size"):
        math_utils.interpolate_poses(pose_1, pose_2)
