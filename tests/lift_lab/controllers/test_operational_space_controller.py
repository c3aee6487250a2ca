"""Operational-space control against the laws it implements."""

import pytest
import torch

from lift_lab.controllers import OperationalSpaceController, OperationalSpaceControllerCfg
from lift_lab.utils.errors import ConfigError
from lift_lab.utils.math import matrix_from_quat, quat_apply, quat_box_minus, random_orientation

N, JOINTS = 3, 7


@pytest.fixture
def arm():
    """A random configuration of a seven-joint arm."""
    torch.manual_seed(2)
    root = torch.randn(N, JOINTS, JOINTS)
    return {
        "jacobian": torch.randn(N, 6, JOINTS),
        "pose": torch.cat((torch.randn(N, 3), random_orientation(N, "cpu")), dim=1),
        "velocity": torch.randn(N, 6),
        "mass": root @ root.mT + 2.0 * torch.eye(JOINTS),
        "gravity": torch.randn(N, JOINTS),
        "joint_pos": torch.randn(N, JOINTS),
        "joint_vel": torch.randn(N, JOINTS),
    }


def _controller(**settings) -> OperationalSpaceController:
    return OperationalSpaceController(OperationalSpaceControllerCfg(**settings), N, "cpu")


def _apply(matrix, vector):
    return (matrix @ vector.unsqueeze(-1)).squeeze(-1)


def _still_pose_error(arm, controller, error):
    """Command a pose that differs from the current one by ``error`` (position, rotation vector)."""
    controller.set_command(error, arm["pose"])


def test_task_space_impedance_is_a_spring_and_a_damper(arm):
    controller = _controller(target_types=["pose_rel"], motion_stiffness_task=100.0, motion_damping_ratio_task=0.5)
    error = 0.1 * torch.randn(N, 6)
    _still_pose_error(arm, controller, error)
    efforts = controller.compute(arm["jacobian"], arm["pose"], arm["velocity"])
    wrench = 100.0 * error - 2.0 * 10.0 * 0.5 * arm["velocity"]
    torch.testing.assert_close(efforts, _apply(arm["jacobian"].mT, wrench), atol=1e-3, rtol=1e-3)


def test_with_inertial_decoupling_the_end_effector_accelerates_as_commanded(arm):
    controller = _controller(target_types=["pose_rel"], motion_stiffness_task=40.0, inertial_dynamics_decoupling=True)
    error = 0.1 * torch.randn(N, 6)
    _still_pose_error(arm, controller, error)
    efforts = controller.compute(arm["jacobian"], arm["pose"], arm["velocity"], mass_matrix=arm["mass"])
    acceleration = _apply(arm["jacobian"], torch.linalg.solve(arm["mass"], efforts))
    wanted = 40.0 * error - 2.0 * 40.0**0.5 * arm["velocity"]
    torch.testing.assert_close(acceleration, wanted, atol=1e-2, rtol=1e-3)


def test_partial_decoupling_treats_translation_and_rotation_apart(arm):
    controller = _controller(
        target_types=["pose_rel"],
        motion_stiffness_task=40.0,
        inertial_dynamics_decoupling=True,
        partial_inertial_dynamics_decoupling=True,
        motion_control_axes_task=(1, 1, 1, 0, 0, 0),
    )
    error = 0.1 * torch.randn(N, 6)
    _still_pose_error(arm, controller, error)
    efforts = controller.compute(arm["jacobian"], arm["pose"], arm["velocity"], mass_matrix=arm["mass"])
    acceleration = _apply(arm["jacobian"][:, :3], torch.linalg.solve(arm["mass"], efforts))
    wanted = 40.0 * error[:, :3] - 2.0 * 40.0**0.5 * arm["velocity"][:, :3]
    torch.testing.assert_close(acceleration, wanted, atol=1e-2, rtol=1e-3)


def test_free_axes_are_those_of_the_task_frame(arm):
    controller = _controller(target_types=["pose_abs"], motion_control_axes_task=(1, 1, 0, 1, 1, 1))
    frame = torch.cat((torch.randn(N, 3), random_orientation(N, "cpu")), dim=1)
    target = torch.cat((torch.randn(N, 3), random_orientation(N, "cpu")), dim=1)
    controller.set_command(target, arm["pose"], frame)
    jacobian = torch.eye(6).repeat(N, 1, 1)
    wrench = controller.compute(jacobian, arm["pose"], arm["velocity"])
    to_task = matrix_from_quat(frame[:, 3:]).mT
    force_task = _apply(to_task, wrench[:, :3])
    torch.testing.assert_close(force_task[:, 2], torch.zeros(N), atol=1e-3, rtol=0)
    # the target is in the task frame
    target_b = frame[:, :3] + quat_apply(frame[:, 3:], target[:, :3])
    torch.testing.assert_close(controller.desired_ee_pose_b[:, :3], target_b)
    expected = _apply(to_task, 100.0 * (target_b - arm["pose"][:, :3]) - 20.0 * arm["velocity"][:, :3])
    torch.testing.assert_close(force_task[:, :2], expected[:, :2], atol=1e-2, rtol=1e-3)


def test_a_free_axis_is_not_damped_either(arm):
    settings = {"motion_stiffness_task": 40.0, "inertial_dynamics_decoupling": True}
    controller = _controller(target_types=["pose_rel"], motion_control_axes_task=(1, 1, 0, 1, 1, 1), **settings)
    error = 0.1 * torch.randn(N, 6)
    _still_pose_error(arm, controller, error)
    efforts = controller.compute(arm["jacobian"], arm["pose"], arm["velocity"], mass_matrix=arm["mass"])
    chosen = torch.tensor([1.0, 1.0, 0.0, 1.0, 1.0, 1.0])
    wanted = chosen * (40.0 * error - 2.0 * 40.0**0.5 * arm["velocity"])
    inertia = torch.linalg.inv(arm["jacobian"] @ torch.linalg.inv(arm["mass"]) @ arm["jacobian"].mT)
    expected = _apply(arm["jacobian"].mT, chosen * _apply(inertia, wanted))
    torch.testing.assert_close(efforts, expected, atol=1e-2, rtol=1e-3)


def test_a_change_of_pose_is_along_the_axes_of_the_task_frame(arm):
    controller = _controller(target_types=["pose_rel"])
    frame = torch.cat((torch.randn(N, 3), random_orientation(N, "cpu")), dim=1)
    change = 0.3 * torch.randn(N, 6)
    controller.set_command(change, arm["pose"], frame)
    wanted, to_b = controller.desired_ee_pose_b, matrix_from_quat(frame[:, 3:])
    torch.testing.assert_close(wanted[:, :3], arm["pose"][:, :3] + _apply(to_b, change[:, :3]), atol=1e-5, rtol=0)
    turn = quat_box_minus(wanted[:, 3:], arm["pose"][:, 3:])
    torch.testing.assert_close(turn, _apply(to_b, change[:, 3:]), atol=1e-5, rtol=0)


def test_a_wrench_of_the_task_frame_has_a_moment_about_the_root():
    controller = _controller(target_types=["wrench_abs"], contact_wrench_control_axes_task=(1, 1, 1, 1, 1, 1))
    # the frame stands at x = 2 and is turned by 90 degrees about z: its x axis is the root's y axis
    frame = torch.tensor([[2.0, 0.0, 0.0, 0.5**0.5, 0.0, 0.0, 0.5**0.5]]).repeat(N, 1)
    controller.set_command(torch.tensor([[3.0, 0.0, 0.0, 1.0, 0.0, 0.5]]).repeat(N, 1), None, frame)
    applied = controller.compute(torch.eye(6).repeat(N, 1, 1))
    expected = torch.tensor([[0.0, 3.0, 0.0, 0.0, 1.0, 0.5 + 2.0 * 3.0]]).repeat(N, 1)
    torch.testing.assert_close(applied, expected, atol=1e-5, rtol=0)


def test_gains_may_come_with_the_command(arm):
    error = 0.1 * torch.randn(N, 6)
    stiffness, ratio = torch.full((N, 6), 30.0), torch.full((N, 6), 0.25)
    stiffness[:, 1] = 5000.0  # beyond its limit of 200
    variable = _controller(
        target_types=["pose_rel"], impedance_mode="variable", motion_stiffness_limits_task=(0.0, 200.0)
    )
    assert variable.action_dim == 18
    variable.set_command(torch.cat((error, stiffness, ratio), dim=1), arm["pose"])
    fixed = _controller(
        target_types=["pose_rel"],
        motion_stiffness_task=(30.0, 200.0, 30.0, 30.0, 30.0, 30.0),
        motion_damping_ratio_task=0.25,
    )
    fixed.set_command(error, arm["pose"])
    args = (arm["jacobian"], arm["pose"], arm["velocity"])
    torch.testing.assert_close(variable.compute(*args), fixed.compute(*args))
    only_kp = _controller(target_types=["pose_rel"], impedance_mode="variable_kp", motion_damping_ratio_task=0.25)
    only_kp.set_command(torch.cat((error, fixed._stiffness.repeat(N, 1)), dim=1), arm["pose"])
    torch.testing.assert_close(only_kp.compute(*args), fixed.compute(*args))


def test_a_wrench_is_applied_through_the_transposed_jacobian(arm):
    controller = _controller(target_types=["wrench_abs"], contact_wrench_control_axes_task=(1, 0, 1, 1, 1, 1))
    wrench = torch.randn(N, 6)
    controller.set_command(wrench)
    efforts = controller.compute(arm["jacobian"])
    applied = wrench * torch.tensor([1.0, 0.0, 1.0, 1.0, 1.0, 1.0])
    torch.testing.assert_close(efforts, _apply(arm["jacobian"].mT, applied), atol=1e-5, rtol=1e-5)


def test_force_feedback_adds_the_scaled_error_of_forces_only():
    controller = _controller(
        target_types=["wrench_abs"],
        contact_wrench_control_axes_task=(1, 1, 1, 1, 1, 1),
        contact_wrench_stiffness_task=0.5,
    )
    wrench, measured = torch.randn(N, 6), torch.randn(N, 3)
    controller.set_command(wrench)
    applied = controller.compute(torch.eye(6).repeat(N, 1, 1), current_ee_force_b=measured)
    torch.testing.assert_close(applied[:, :3], wrench[:, :3] + 0.5 * (wrench[:, :3] - measured))
    torch.testing.assert_close(applied[:, 3:], wrench[:, 3:])


def test_gravity_efforts_are_added(arm):
    controller = _controller(target_types=["wrench_abs"], gravity_compensation=True)
    controller.set_command(torch.randn(N, 6))
    torch.testing.assert_close(controller.compute(arm["jacobian"], gravity=arm["gravity"]), arm["gravity"])


@pytest.mark.parametrize("decoupling", [True, False])
def test_null_space_efforts_do_not_move_the_end_effector(arm, decoupling):
    controller = _controller(
        target_types=["wrench_abs"],
        nullspace_control="position",
        nullspace_stiffness=9.0,
    )
    controller.set_command(torch.zeros(N, 6))
    motion = {}
    if decoupling:
        controller = _controller(
            target_types=["pose_rel"], inertial_dynamics_decoupling=True, nullspace_control="position"
        )
        controller.set_command(torch.zeros(N, 6), arm["pose"])
        motion = {"current_ee_pose_b": arm["pose"], "current_ee_vel_b": torch.zeros(N, 6)}
    mass = arm["mass"] if decoupling else None
    state = {"current_joint_pos": arm["joint_pos"], "current_joint_vel": arm["joint_vel"], "mass_matrix": mass}

    def pulled_to(target):
        return controller.compute(arm["jacobian"], **motion, **state, nullspace_joint_pos_target=target)

    efforts = pulled_to(torch.ones(N, JOINTS))
    torch.testing.assert_close(pulled_to(None), pulled_to(torch.zeros(N, JOINTS)))
    assert efforts.norm(dim=1).min() > 0.1
    if decoupling:
        moved = _apply(arm["jacobian"], torch.linalg.solve(mass, efforts))
        torch.testing.assert_close(moved, torch.zeros(N, 6), atol=1e-2, rtol=0)
    else:
        # statically: no wrench at the end effector, the effort is orthogonal to the Jacobian's rows
        torch.testing.assert_close(_apply(arm["jacobian"], efforts), torch.zeros(N, 6), atol=1e-3, rtol=0)
        spring = 9.0 * (1.0 - arm["joint_pos"]) - 6.0 * arm["joint_vel"]
        # a projection takes nothing away along itself
        torch.testing.assert_close((efforts * spring).sum(1), efforts.square().sum(1), atol=1e-2, rtol=1e-3)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"target_types": ["pose"]}, "pose_abs"),
        ({"target_types": ["pose_abs"], "impedance_mode": "variable_k"}, "variable_kp"),
        ({"target_types": ["pose_abs"], "nullspace_control": "pos"}, "position"),
    ],
)
def test_an_unknown_setting_is_an_error(settings, message):
    with pytest.raises(ConfigError, match=message):
        _controller(**settings)


def test_missing_inputs_are_named(arm):
    controller = _controller(target_types=["pose_rel"], inertial_dynamics_decoupling=True)
    with pytest.raises(ConfigError, match=r"\(3, 6\)"):
        controller.set_command(torch.zeros(N, 7))
    with pytest.raises(ConfigError, match="current end-effector pose"):
        controller.set_command(torch.zeros(N, 6))
    controller.set_command(torch.zeros(N, 6), arm["pose"])
    with pytest.raises(ConfigError, match="current_ee_vel_b"):
        controller.compute(arm["jacobian"], arm["pose"])
    with pytest.raises(ConfigError, match="mass_matrix"):
        controller.compute(arm["jacobian"], arm["pose"], arm["velocity"])


def test_null_space_control_needs_a_redundant_arm(arm):
    controller = _controller(target_types=["wrench_abs"], nullspace_control="position")
    controller.set_command(torch.zeros(N, 6))
    with pytest.raises(ConfigError, match="6 joints"):
        controller.compute(
            arm["jacobian"][:, :, :6],
            current_joint_pos=arm["joint_pos"][:, :6],
            current_joint_vel=arm["joint_vel"][:, :6],
        )
