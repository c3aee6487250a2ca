"""Differential inverse kinematics against closed forms."""

import math

import pytest
import torch
from scipy.spatial.transform import Rotation

from lift_lab.controllers import DifferentialIKController, DifferentialIKControllerCfg
from lift_lab.utils.errors import ConfigError

N = 4
IDENTITY = torch.tensor([[1.0, 0.0, 0.0, 0.0]]).repeat(N, 1)


def _controller(**settings) -> DifferentialIKController:
    return DifferentialIKController(DifferentialIKControllerCfg(**settings), N, "cpu")


def _problem(rows: int = 6, joints: int = 7):
    torch.manual_seed(3)
    return torch.randn(N, 6, joints), torch.randn(N, rows), torch.randn(N, joints)


def _step(controller, jacobian, error, joint_pos):
    """Joint step for a position error, from the origin."""
    controller.set_command(error, torch.zeros(N, 3), IDENTITY)
    return controller.compute(torch.zeros(N, 3), IDENTITY, jacobian, joint_pos) - joint_pos


@pytest.mark.parametrize(
    ("settings", "size"),
    [
        ({"command_type": "position"}, 3),
        ({"command_type": "position", "use_relative_mode": True}, 3),
        ({"command_type": "pose"}, 7),
        ({"command_type": "pose", "use_relative_mode": True}, 6),
    ],
)
def test_the_size_of_a_command_follows_its_type(settings, size):
    assert _controller(ik_method="pinv", **settings).action_dim == size


@pytest.mark.parametrize("method", ["pinv", "svd"])
def test_a_pseudo_inverse_step_is_the_shortest_that_closes_the_gap(method):
    jacobian, error, joint_pos = _problem(3)
    step = _step(_controller(command_type="position", ik_method=method), jacobian, error, joint_pos)
    position_jacobian = jacobian[:, :3]
    gap = (position_jacobian @ step.unsqueeze(-1)).squeeze(-1)
    torch.testing.assert_close(gap, error, atol=1e-4, rtol=1e-4)
    shortest = torch.linalg.lstsq(position_jacobian, error.unsqueeze(-1), driver="gelsd").solution.squeeze(-1)
    torch.testing.assert_close(step, shortest, atol=1e-4, rtol=1e-4)


@pytest.mark.parametrize("method", ["pinv", "svd", "trans"])
def test_the_gain_scales_the_step(method):
    jacobian, error, joint_pos = _problem(3)
    settings = {"command_type": "position", "ik_method": method}
    full = _step(_controller(**settings), jacobian, error, joint_pos)
    half = _step(_controller(**settings, ik_params={"k_val": 0.5}), jacobian, error, joint_pos)
    torch.testing.assert_close(half, 0.5 * full, atol=1e-5, rtol=1e-5)


def test_the_transpose_step_is_the_gradient_of_the_error():
    jacobian, error, joint_pos = _problem(3)
    step = _step(_controller(command_type="position", ik_method="trans"), jacobian, error, joint_pos)
    q = torch.zeros(N, 7, requires_grad=True)
    gap = error - (jacobian[:, :3] @ q.unsqueeze(-1)).squeeze(-1)
    (-0.5 * gap.square().sum()).backward()
    torch.testing.assert_close(step, q.grad, atol=1e-5, rtol=1e-5)


def test_damped_least_squares_balances_gap_and_step():
    jacobian, error, joint_pos = _problem(3)
    damping = 0.7
    controller = _controller(command_type="position", ik_method="dls", ik_params={"lambda_val": damping})
    step = _step(controller, jacobian, error, joint_pos)
    # minimise |J dq - e|^2 + lambda^2 |dq|^2: least squares with lambda I stacked below J
    stacked = torch.cat((jacobian[:, :3], damping * torch.eye(7).expand(N, 7, 7)), dim=1)
    wanted = torch.cat((error, torch.zeros(N, 7)), dim=1).unsqueeze(-1)
    expected = torch.linalg.lstsq(stacked, wanted).solution.squeeze(-1)
    torch.testing.assert_close(step, expected, atol=1e-4, rtol=1e-4)


def test_small_singular_values_are_left_out():
    jacobian = torch.zeros(N, 6, 3)
    jacobian[:, 0, 0], jacobian[:, 1, 1] = 2.0, 1e-4
    error = torch.tensor([[1.0, 1.0, 0.0]]).repeat(N, 1)
    settings = {"command_type": "position", "ik_method": "svd"}
    step = _step(_controller(**settings, ik_params={"min_singular_value": 1e-3}), jacobian, error, torch.zeros(N, 3))
    torch.testing.assert_close(step, torch.tensor([[0.5, 0.0, 0.0]]).repeat(N, 1))
    step = _step(_controller(**settings), jacobian, error, torch.zeros(N, 3))
    torch.testing.assert_close(step[0, 1], torch.tensor(1e4))


def test_an_absolute_pose_is_approached_along_its_rotation_vector():
    controller = _controller(command_type="pose", ik_method="pinv")
    current, wanted = Rotation.from_euler("xyz", [0.3, -0.4, 1.0]), Rotation.from_euler("xyz", [1.0, 0.2, -0.5])
    quats = [torch.tensor(r.as_quat()[[3, 0, 1, 2]], dtype=torch.float32).repeat(N, 1) for r in (current, wanted)]
    position = torch.tensor([[0.1, 0.2, 0.3]]).repeat(N, 1)
    # quaternions of any length and sign name the same orientation
    controller.set_command(torch.cat((position + 0.5, -2.0 * quats[1]), dim=1))
    joints = controller.compute(position, quats[0], torch.eye(6).repeat(N, 1, 1), torch.zeros(N, 6))
    rotation = torch.tensor((wanted * current.inv()).as_rotvec(), dtype=torch.float32)
    expected = torch.cat((torch.full((3,), 0.5), rotation)).repeat(N, 1)
    torch.testing.assert_close(joints, expected, atol=1e-5, rtol=0)


def test_a_relative_pose_starts_at_the_current_one():
    controller = _controller(command_type="pose", use_relative_mode=True, ik_method="pinv")
    position, quat = torch.randn(N, 3), torch.nn.functional.normalize(torch.randn(N, 4), dim=1)
    change = torch.tensor([[0.1, 0.0, -0.2, 0.3, -0.1, 0.2]]).repeat(N, 1)
    controller.set_command(change, position, quat)
    joints = controller.compute(position, quat, torch.eye(6).repeat(N, 1, 1), torch.zeros(N, 6))
    torch.testing.assert_close(joints, change, atol=1e-5, rtol=0)


@pytest.mark.parametrize("relative", [False, True])
def test_repeated_steps_bring_a_planar_arm_to_its_target(relative):
    lengths = (0.5, 0.4)
    q = torch.tensor([[0.3, 0.6], [0.2, 1.0], [-0.5, 0.8], [1.0, 0.4]])
    target = torch.tensor([[0.5, 0.4, 0.0]]).repeat(N, 1)

    def kinematics(q):
        a, b = q[:, 0], q[:, 0] + q[:, 1]
        x = lengths[0] * torch.cos(a) + lengths[1] * torch.cos(b)
        y = lengths[0] * torch.sin(a) + lengths[1] * torch.sin(b)
        jacobian = torch.zeros(N, 6, 2)
        jacobian[:, 0, 0], jacobian[:, 1, 0] = -y, x
        jacobian[:, 0, 1], jacobian[:, 1, 1] = -lengths[1] * torch.sin(b), lengths[1] * torch.cos(b)
        return torch.stack((x, y, torch.zeros_like(x)), dim=-1), jacobian

    controller = _controller(command_type="position", use_relative_mode=relative, ik_method="dls")
    position, jacobian = kinematics(q)
    controller.set_command(target - position if relative else target, position, IDENTITY)
    for _ in range(30):
        position, jacobian = kinematics(q)
        q = controller.compute(position, IDENTITY, jacobian, q)
    torch.testing.assert_close(kinematics(q)[0], target, atol=1e-4, rtol=0)
    distance = math.hypot(0.5, 0.4)
    elbow = math.acos((distance**2 - 0.5**2 - 0.4**2) / (2 * 0.5 * 0.4))
    torch.testing.assert_close(q[:, 1].cos(), torch.full((N,), math.cos(elbow)), atol=1e-3, rtol=0)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"command_type": "pos", "ik_method": "dls"}, "command_type.*'position'"),
        ({"command_type": "pose", "ik_method": "dlss"}, "ik_method.*'dls'"),
        ({"command_type": "pose", "ik_method": "dls", "ik_params": {"lambda": 1.0}}, "lambda_val"),
    ],
)
def test_a_config_that_makes_no_sense_is_an_error(settings, message):
    with pytest.raises(ConfigError, match=message):
        DifferentialIKControllerCfg(**settings)


def test_a_relative_command_needs_the_current_pose():
    controller = _controller(command_type="pose", use_relative_mode=True, ik_method="dls")
    with pytest.raises(ConfigError, match="position"):
        controller.set_command(torch.zeros(N, 6))
    with pytest.raises(ConfigError, match="orientation"):
        controller.set_command(torch.zeros(N, 6), torch.zeros(N, 3))
