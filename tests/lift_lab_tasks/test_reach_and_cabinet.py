"""Reach and cabinet tasks do what their names say: inverse kinematics reaches, and a drawer that is pulled opens."""

import math

import numpy as np
import pytest
import torch
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from lift_lab.controllers import DifferentialIKControllerCfg
from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.utils.math import compute_pose_error
from lift_lab_tasks.manager_based.manipulation.cabinet import mdp as cabinet_mdp
from lift_lab_tasks.manager_based.manipulation.cabinet.config.franka.joint_pos_env_cfg import FrankaCabinetEnvCfg
from lift_lab_tasks.manager_based.manipulation.reach import mdp as reach_mdp
from lift_lab_tasks.manager_based.manipulation.reach.config.franka import ik_abs_env_cfg, ik_rel_env_cfg


def _make(cfg, num_envs: int) -> ManagerBasedRLEnv:
    cfg.scene.num_envs = num_envs
    cfg.sim.device = "cpu"
    cfg.sim.num_threads = 1
    cfg.seed = 3
    env = ManagerBasedRLEnv(cfg)
    env.reset()
    return env


# -- reach


def _hand_error(env):
    """Distance (m) and angle (rad) of the hand to its command, and both as vectors in the robot's root frame."""
    robot = env.scene["robot"]
    hand = robot.body_names.index("panda_hand")
    command = env.command_manager.get_command("ee_pose")
    pos_b = robot.data.body_pos_w[:, hand] - robot.data.root_pos_w
    error = compute_pose_error(
        pos_b, robot.data.body_quat_w[:, hand], command[:, :3], command[:, 3:], rot_error_type="axis_angle"
    )
    return *(vector.norm(dim=1) for vector in error), torch.cat(error, dim=1)


def test_the_command_as_an_absolute_action_brings_the_hand_within_2_cm():
    env = _make(ik_abs_env_cfg.FrankaReachEnvCfg(), 32)
    for _ in range(120):
        env.step(env.command_manager.get_command("ee_pose"))
    distance, angle, _ = _hand_error(env)
    assert (distance < 0.02).float().mean() >= 0.9
    assert torch.equal(reach_mdp.pose_reached(env), (distance < 0.02) & (angle < 0.2))
    # A yaw that joint 7 cannot turn to keeps some from the angle
    assert (angle < 0.2).float().mean() >= 0.8
    env.close()


def test_the_error_as_a_relative_action_brings_the_hand_within_2_cm():
    env = _make(ik_rel_env_cfg.FrankaReachEnvCfg(), 32)
    for _ in range(120):
        env.step((_hand_error(env)[2] / 0.5).clamp(-1.0, 1.0))
    missed = _hand_error(env)[0] >= 0.02
    assert missed.float().mean() <= 0.25
    # The straight way to some yaws leads into a joint's limit, of which inverse kinematics knows nothing
    robot = env.scene["robot"]
    low, high = robot.data.joint_pos_limits.unbind(-1)
    at_limit = ((robot.data.joint_pos < low + 0.02) | (robot.data.joint_pos > high - 0.02))[:, :7].any(dim=1)
    assert at_limit[missed].float().mean() >= 0.8
    assert at_limit[~missed].float().mean() <= 0.3
    env.close()


# -- cabinet


def test_the_handle_is_where_a_hand_with_its_left_finger_on_top_would_grasp_it():
    env = _make(FrankaCabinetEnvCfg(), 2)
    frame = env.scene["cabinet_frame"].data
    # The cabinet is turned by 180 degrees: its front looks at the robot
    np.testing.assert_allclose(
        frame.target_pos_w[:, 0] - env.scene.env_origins, [[0.8 - 0.305, 0.0, 0.4 + 0.205 + 0.01]] * 2, atol=1e-5
    )
    axes = Rotation.from_quat(frame.target_quat_w[0, 0], scalar_first=True).as_matrix()
    np.testing.assert_allclose(axes[:, 2], [1.0, 0.0, 0.0], atol=1e-5)  # the hand looks away from the robot
    np.testing.assert_allclose(axes[:, 1], [0.0, 0.0, 1.0], atol=1e-5)  # and its left finger is on top
    env.close()


def test_a_drawer_pulled_by_its_handle_moves_as_a_mass_on_a_damped_spring_until_its_stop():
    cfg = FrankaCabinetEnvCfg()
    cfg.scene.robot.init_state.joint_pos.update({"panda_joint1": 2.6, "panda_joint2": 0.5})  # out of the way
    env = _make(cfg, 2)
    cabinet = env.scene["cabinet"]
    handle, drawer = cabinet.body_names.index("drawer_handle_top"), cabinet.joint_names.index("drawer_top_joint")
    pull_w = torch.tensor([[-10.0, 0.0, 0.0], [0.0, 0.0, 0.0]])[:, None]
    cabinet.set_external_force_and_torque(pull_w, torch.zeros_like(pull_w), body_ids=[handle], is_global=True)
    opened = []
    for _ in range(50):
        env.step(torch.zeros(2, 8))
        opened.append(cabinet.data.joint_pos[0, drawer].item())
    mass = 5.0 + 0.2  # drawer and handle; stiffness 10 N/m, damping 1 N s/m
    times = 0.02 * np.arange(1, 31)
    motion = solve_ivp(lambda t, y: (y[1], (10.0 - 10.0 * y[0] - y[1]) / mass), (0, 1), (0, 0), t_eval=times, rtol=1e-8)
    free = motion.y[0] < 0.38
    np.testing.assert_allclose(np.array(opened[: len(times)])[free], motion.y[0][free], atol=0.005)
    assert opened[-1] == pytest.approx(0.4, abs=0.02)
    assert cabinet_mdp.drawer_is_open(env).tolist() == [True, False]
    assert abs(cabinet.data.joint_pos[1, drawer].item()) < 1e-3
    others = [i for i in range(4) if i != drawer]
    assert cabinet.data.joint_pos[:, others].abs().max() < 1e-2
    env.close()


def test_a_door_swings_out_of_the_cabinet_on_either_side():
    env = _make(FrankaCabinetEnvCfg(), 1)
    cabinet = env.scene["cabinet"]
    for side, sign in (("left", 1), ("right", -1)):
        joint = cabinet.joint_names.index(f"door_{side}_joint")
        position = torch.zeros(1, 4)
        position[0, joint] = math.pi / 2
        cabinet.write_joint_state_to_sim(position, torch.zeros_like(position))
        env.sim.physics.refresh()
        body = cabinet.body_names.index(f"door_{side}")
        # A point on the closed door's middle, 0.17 m from the hinge, is now as far before the hinge
        turn = Rotation.from_quat(cabinet.data.body_quat_w[0, body], scalar_first=True)
        offset_w = turn.apply([0.0, -sign * 0.17, 0.0])
        np.testing.assert_allclose(offset_w, [-0.17, 0.0, 0.0], atol=1e-4)
    env.close()


def test_rewards_of_the_cabinet_have_their_closed_forms_at_the_start():
    env = _make(FrankaCabinetEnvCfg(), 3)
    tool = env.scene["ee_frame"].data
    handle = env.scene["cabinet_frame"].data
    way = (handle.target_pos_w[:, 0] - tool.target_pos_w[:, 0]).numpy()
    np.testing.assert_allclose(cabinet_mdp.rel_ee_drawer_distance(env), way, atol=1e-6)
    distance = np.linalg.norm(way, axis=1)
    assert (distance > 0.2).all()
    np.testing.assert_allclose(cabinet_mdp.approach_ee_handle(env, 0.2), 1 / (1 + distance**2) ** 2, rtol=1e-5)
    np.testing.assert_allclose(cabinet_mdp.approach_ee_handle(env, 9.0), 2 / (1 + distance**2) ** 2, rtol=1e-5)
    hand, goal = (
        Rotation.from_quat(quat[:, 0], scalar_first=True).as_matrix()
        for quat in (tool.target_quat_w, handle.target_quat_w)
    )
    along_z, along_x = ((hand[:, :, i] * goal[:, :, i]).sum(axis=1) for i in (2, 0))
    expected = 0.5 * (along_z * abs(along_z) + along_x * abs(along_x))
    np.testing.assert_allclose(cabinet_mdp.align_ee_handle(env), expected, atol=1e-5)
    # The hand looks down, its fingers beside each other
    assert not cabinet_mdp.align_grasp_around_handle(env).any()
    assert not cabinet_mdp.approach_gripper_handle(env).any()
    np.testing.assert_allclose(cabinet_mdp.fingertips_pos(env).shape, (3, 6))
    env.close()


def test_a_scripted_hand_grasps_the_handle_and_opens_the_drawer_by_20_cm():
    cfg = FrankaCabinetEnvCfg()
    for group in ("panda_shoulder", "panda_forearm"):
        cfg.scene.robot.actuators[group].damping = 80.0
    cfg.actions.arm_action = cabinet_mdp.DifferentialInverseKinematicsActionCfg(
        asset_name="robot",
        joint_names=["panda_joint.*"],
        body_name="panda_hand",
        controller=DifferentialIKControllerCfg(
            command_type="pose", use_relative_mode=False, ik_method="dls", ik_params={"lambda_val": 0.05}
        ),
        body_offset=cabinet_mdp.DifferentialInverseKinematicsActionCfg.OffsetCfg(pos=(0.0, 0.0, 0.1034)),
    )
    env = _make(cfg, 4)
    best = torch.zeros(4)
    for step in range(270):
        handle = env.scene["cabinet_frame"].data
        goal = handle.target_pos_w[:, 0] - env.scene.env_origins
        if step < 70:
            goal[:, 0] -= 0.12  # turn before the handle
        elif step >= 160:
            goal[:, 0] -= 0.06  # pull: the goal stays ahead of the drawer
        gripper = torch.full((4, 1), 1.0 if step < 130 else -1.0)
        env.step(torch.cat((goal, handle.target_quat_w[:, 0], gripper), dim=1))
        best = torch.maximum(best, env.scene["cabinet"].data.joint_pos[:, 0])
        if step == 155:
            assert cabinet_mdp.align_grasp_around_handle(env).all()
    assert (best > 0.2).sum() >= 3, best
    env.close()
