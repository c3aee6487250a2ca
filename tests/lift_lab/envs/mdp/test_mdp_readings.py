"""Observation, reward and termination terms on hand-made states."""

import math
from types import SimpleNamespace

import pytest
import torch

import lift_lab.envs.mdp as mdp
from lift_lab.managers import RewardTermCfg, SceneEntityCfg

HALF = SceneEntityCfg("robot", joint_ids=[2, 0], body_ids=[1])
SECOND = SceneEntityCfg("robot", joint_ids=[1])
"""A joint that leaves its limits downwards."""


@pytest.fixture
def env():
    """Two environments of a robot with three joints and two bodies."""
    tilt = math.radians(30.0)
    data = SimpleNamespace(
        root_pos_w=torch.tensor([[1.0, 2.0, 0.3], [4.0, 2.0, 0.7]]),
        root_quat_w=torch.tensor([[1.0, 0.0, 0.0, 0.0], [-0.6, 0.8, 0.0, 0.0]]),
        root_lin_vel_w=torch.tensor([[0.5, 0.0, 0.1], [0.0, 0.6, 0.0]]),
        root_ang_vel_w=torch.tensor([[0.0, 0.2, 0.0], [0.7, 0.0, -0.7]]),
        root_lin_vel_b=torch.tensor([[0.1, 0.2, 0.3], [1.0, -2.0, 0.5]]),
        root_ang_vel_b=torch.tensor([[0.3, 0.4, 1.0], [0.0, -1.0, 2.0]]),
        projected_gravity_b=torch.tensor([[0.0, 0.0, -1.0], [math.sin(tilt), 0.0, -math.cos(tilt)]]),
        body_pos_w=torch.tensor([[[1.0, 2.0, 0.3], [1.0, 2.0, 1.3]], [[4.0, 2.0, 0.7], [5.0, 2.0, 0.7]]]),
        body_quat_w=torch.tensor([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]).repeat(2, 1, 1),
        body_lin_acc_w=torch.tensor([[[3.0, 4.0, 0.0], [0.0, 0.0, 2.0]]]).repeat(2, 1, 1),
        GRAVITY_VEC_W=torch.tensor([[0.0, 0.0, -1.0]]).repeat(2, 1),
        joint_pos=torch.tensor([[0.1, 0.2, 0.3], [1.5, -2.5, 0.0]]),
        joint_vel=torch.tensor([[1.0, -2.0, 3.0], [0.0, 0.5, -0.5]]),
        joint_acc=torch.tensor([[1.0, 1.0, 2.0], [0.0, 3.0, 0.0]]),
        default_joint_pos=torch.tensor([[0.0, 0.1, 0.2]]).repeat(2, 1),
        default_joint_vel=torch.tensor([[0.5, 0.0, 0.0]]).repeat(2, 1),
        soft_joint_pos_limits=torch.tensor([[[-1.0, 1.0], [-2.0, 2.0], [0.1, 0.5]]]).repeat(2, 1, 1),
        soft_joint_vel_limits=torch.tensor([[1.5, 1.5, 2.0]]).repeat(2, 1),
        applied_torque=torch.tensor([[1.0, -2.0, 3.0], [0.0, 0.0, 5.0]]),
        computed_torque=torch.tensor([[1.0, -2.0, 3.0], [0.0, -0.5, 9.0]]),
    )
    forces = torch.zeros(2, 2, 2, 3)  # environments, history, bodies
    forces[0, 1, 0, 2] = 5.0
    forces[1, 0, 1] = torch.tensor([3.0, 4.0, 0.0])
    command = torch.tensor([[0.1, 0.2, 1.0], [0.0, 0.0, 0.0]])
    imu = SimpleNamespace(
        quat_w=torch.tensor([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]),
        projected_gravity_b=torch.tensor([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]),
        ang_vel_b=torch.tensor([[0.1, 0.0, 0.0], [0.0, 0.0, 0.2]]),
        lin_acc_b=torch.tensor([[0.0, 0.0, 9.81], [1.0, 0.0, -9.81]]),
    )
    scene = {"robot": SimpleNamespace(data=data), "imu": SimpleNamespace(data=imu)}
    return SimpleNamespace(
        num_envs=2,
        device="cpu",
        step_dt=0.02,
        max_episode_length=5,
        max_episode_length_s=0.09,
        episode_length_buf=torch.tensor([4, 5]),
        scene=_Scene(scene, torch.tensor([[1.0, 1.0, 0.0], [4.0, 1.0, 0.0]]), forces),
        action_manager=SimpleNamespace(
            action=torch.tensor([[1.0, 2.0], [0.0, -1.0]]),
            prev_action=torch.tensor([[0.0, 0.0], [0.0, 1.0]]),
            get_term=lambda name: SimpleNamespace(raw_actions=torch.full((2, 1), {"grip": 3.0}[name])),
        ),
        command_manager=SimpleNamespace(
            get_command=lambda name: {"velocity": command}[name],
            get_term=lambda name: SimpleNamespace(
                time_left=torch.tensor([0.01, 0.5]), command_counter=torch.tensor([1, 1])
            ),
        ),
        termination_manager=SimpleNamespace(
            terminated=torch.tensor([True, False]),
            time_outs=torch.tensor([False, True]),
            find_terms=lambda keys: ["fell", "hit"] if keys == ".*" else [keys],
            get_term=lambda name: {"fell": torch.tensor([True, False]), "hit": torch.tensor([True, True])}[name],
        ),
    )


class _Scene(dict):
    def __init__(self, entities, env_origins, forces):
        super().__init__(entities)
        self.env_origins = env_origins
        self.sensors = {"contact": SimpleNamespace(data=SimpleNamespace(net_forces_w_history=forces))}


CONTACT = SceneEntityCfg("contact", body_ids=[1])
ANY_CONTACT = SceneEntityCfg("contact")
SIN30, COS30 = 0.5, math.cos(math.radians(30.0))

OBSERVATIONS = [
    (mdp.base_pos_z, {}, [[0.3], [0.7]]),
    (mdp.base_lin_vel, {}, [[0.1, 0.2, 0.3], [1.0, -2.0, 0.5]]),
    (mdp.base_ang_vel, {}, [[0.3, 0.4, 1.0], [0.0, -1.0, 2.0]]),
    (mdp.root_lin_vel_w, {}, [[0.5, 0.0, 0.1], [0.0, 0.6, 0.0]]),
    (mdp.root_ang_vel_w, {}, [[0.0, 0.2, 0.0], [0.7, 0.0, -0.7]]),
    (mdp.imu_orientation, {}, [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]]),
    (mdp.imu_projected_gravity, {}, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]),
    (mdp.imu_ang_vel, {}, [[0.1, 0.0, 0.0], [0.0, 0.0, 0.2]]),
    (mdp.imu_lin_acc, {}, [[0.0, 0.0, 9.81], [1.0, 0.0, -9.81]]),
    (mdp.projected_gravity, {}, [[0.0, 0.0, -1.0], [SIN30, 0.0, -COS30]]),
    (mdp.root_pos_w, {}, [[0.0, 1.0, 0.3], [0.0, 1.0, 0.7]]),
    (mdp.root_quat_w, {}, [[1.0, 0.0, 0.0, 0.0], [-0.6, 0.8, 0.0, 0.0]]),
    (mdp.root_quat_w, {"make_quat_unique": True}, [[1.0, 0.0, 0.0, 0.0], [0.6, -0.8, 0.0, 0.0]]),
    (
        mdp.body_pose_w,
        {"asset_cfg": HALF},
        [[0.0, 1.0, 1.3, 0.0, 1.0, 0.0, 0.0], [1.0, 1.0, 0.7, 0.0, 1.0, 0.0, 0.0]],
    ),
    # the second body hangs upside down
    (mdp.body_projected_gravity_b, {}, [[0.0, 0.0, -1.0, 0.0, 0.0, 1.0]] * 2),
    (mdp.joint_pos, {"asset_cfg": HALF}, [[0.3, 0.1], [0.0, 1.5]]),
    (mdp.joint_pos_rel, {}, [[0.1, 0.1, 0.1], [1.5, -2.6, -0.2]]),
    (mdp.joint_pos_limit_normalized, {"asset_cfg": HALF}, [[0.0, 0.1], [-1.5, 1.5]]),
    (mdp.joint_vel_rel, {}, [[0.5, -2.0, 3.0], [-0.5, 0.5, -0.5]]),
    (mdp.joint_effort, {"asset_cfg": HALF}, [[3.0, 1.0], [5.0, 0.0]]),
    (mdp.last_action, {}, [[1.0, 2.0], [0.0, -1.0]]),
    (mdp.last_action, {"action_name": "grip"}, [[3.0], [3.0]]),
    (mdp.generated_commands, {"command_name": "velocity"}, [[0.1, 0.2, 1.0], [0.0, 0.0, 0.0]]),
    (mdp.current_time_s, {}, [[0.08], [0.1]]),
    (mdp.remaining_time_s, {}, [[0.01], [-0.01]]),
]

REWARDS = [
    (mdp.is_alive, {}, [0.0, 1.0]),
    (mdp.is_terminated, {}, [1.0, 0.0]),
    (mdp.lin_vel_z_l2, {}, [0.09, 0.25]),
    (mdp.ang_vel_xy_l2, {}, [0.25, 1.0]),
    (mdp.flat_orientation_l2, {}, [0.0, 0.25]),
    (mdp.base_height_l2, {"target_height": 0.5}, [0.04, 0.04]),
    (mdp.body_lin_acc_l2, {}, [7.0, 7.0]),
    (mdp.joint_torques_l2, {}, [14.0, 25.0]),
    (mdp.joint_vel_l1, {"asset_cfg": HALF}, [4.0, 0.5]),
    (mdp.joint_vel_l2, {}, [14.0, 0.5]),
    (mdp.joint_acc_l2, {}, [6.0, 9.0]),
    (mdp.joint_deviation_l1, {}, [0.3, 4.3]),
    # 0.5 above, 0.5 below, 0.1 below
    (mdp.joint_pos_limits, {}, [0.0, 1.1]),
    # limits 0.75, 0.75, 1.0: beyond by 0.25, 1.25 (at most 1), 2 (at most 1)
    (mdp.joint_vel_limits, {"soft_ratio": 0.5}, [2.25, 0.0]),
    (mdp.applied_torque_limits, {}, [0.0, 4.5]),
    (mdp.action_rate_l2, {}, [5.0, 4.0]),
    (mdp.action_l2, {}, [5.0, 1.0]),
    (mdp.undesired_contacts, {"threshold": 1.0, "sensor_cfg": ANY_CONTACT}, [1.0, 1.0]),
    (mdp.undesired_contacts, {"threshold": 1.0, "sensor_cfg": CONTACT}, [0.0, 1.0]),
    (mdp.desired_contacts, {"sensor_cfg": CONTACT}, [1.0, 0.0]),
    (mdp.desired_contacts, {"sensor_cfg": ANY_CONTACT}, [0.0, 0.0]),
    (mdp.contact_forces, {"threshold": 1.0, "sensor_cfg": ANY_CONTACT}, [4.0, 4.0]),
    (mdp.track_lin_vel_xy_exp, {"std": 2.0, "command_name": "velocity"}, [1.0, math.exp(-5.0 / 4.0)]),
    (mdp.track_ang_vel_z_exp, {"std": 2.0, "command_name": "velocity"}, [1.0, math.exp(-1.0)]),
]

TERMINATIONS = [
    (mdp.time_out, {}, [False, True]),
    (mdp.command_resample, {"command_name": "velocity"}, [True, False]),
    (mdp.command_resample, {"command_name": "velocity", "num_resamples": 2}, [False, False]),
    (mdp.command_resample, {"command_name": "velocity", "num_resamples": 0}, [False, False]),
    (mdp.bad_orientation, {"limit_angle": 0.5}, [False, True]),
    (mdp.bad_orientation, {"limit_angle": 0.55}, [False, False]),
    (mdp.root_height_below_minimum, {"minimum_height": 0.5}, [True, False]),
    (mdp.joint_pos_out_of_limit, {}, [False, True]),
    (mdp.joint_pos_out_of_limit, {"asset_cfg": SceneEntityCfg("robot", joint_ids=[0])}, [False, True]),
    (mdp.joint_pos_out_of_limit, {"asset_cfg": SECOND}, [False, True]),
    (mdp.joint_pos_out_of_manual_limit, {"bounds": (-3.0, 1.0)}, [False, True]),
    (mdp.joint_pos_out_of_manual_limit, {"bounds": (-2.0, 3.0)}, [False, True]),
    (mdp.joint_vel_out_of_limit, {}, [True, False]),
    (mdp.joint_vel_out_of_limit, {"asset_cfg": SECOND}, [True, False]),
    (mdp.joint_vel_out_of_manual_limit, {"max_velocity": 0.4}, [True, True]),
    (mdp.joint_vel_out_of_manual_limit, {"max_velocity": 3.0}, [False, False]),
    (mdp.joint_vel_out_of_manual_limit, {"max_velocity": 1.0, "asset_cfg": SECOND}, [True, False]),
    (mdp.joint_effort_out_of_limit, {}, [False, True]),
    (mdp.joint_effort_out_of_limit, {"asset_cfg": SECOND}, [False, True]),
    (mdp.illegal_contact, {"threshold": 4.9, "sensor_cfg": CONTACT}, [False, True]),
    # in the first environment a step ago
    (mdp.illegal_contact, {"threshold": 4.9, "sensor_cfg": ANY_CONTACT}, [True, True]),
    (mdp.illegal_contact, {"threshold": 5.1, "sensor_cfg": ANY_CONTACT}, [False, False]),
]


def _names(cases):
    return [f"{func.__name__}-{k}" for k, (func, _, _) in enumerate(cases)]


@pytest.mark.parametrize(("func", "params", "expected"), OBSERVATIONS, ids=_names(OBSERVATIONS))
def test_an_observation_is_what_its_name_says(env, func, params, expected):
    torch.testing.assert_close(func(env, **params), torch.tensor(expected), atol=1e-6, rtol=1e-6)


def test_gravity_is_seen_from_a_body_that_was_turned(env):
    half = math.sqrt(0.5)
    env.scene["robot"].data.body_quat_w[1, 1] = torch.tensor([half, half, 0.0, 0.0])  # its y axis points up
    expected = torch.tensor([[0.0, 0.0, -1.0, 0.0, 0.0, 1.0], [0.0, 0.0, -1.0, 0.0, -1.0, 0.0]])
    torch.testing.assert_close(mdp.body_projected_gravity_b(env), expected, atol=1e-6, rtol=0)


@pytest.mark.parametrize(("func", "params", "expected"), REWARDS, ids=_names(REWARDS))
def test_a_reward_is_what_its_name_says(env, func, params, expected):
    torch.testing.assert_close(func(env, **params).float(), torch.tensor(expected), atol=1e-6, rtol=1e-6)


@pytest.mark.parametrize(("func", "params", "expected"), TERMINATIONS, ids=_names(TERMINATIONS))
def test_a_termination_fires_when_its_name_says(env, func, params, expected):
    result = func(env, **params)
    assert result.dtype == torch.bool
    assert result.tolist() == expected


@pytest.mark.parametrize(("keys", "expected"), [(".*", [2.0, 0.0]), ("hit", [1.0, 0.0])])
def test_terminations_are_counted_unless_time_ended_the_episode(env, keys, expected):
    cfg = RewardTermCfg(func=mdp.is_terminated_term, weight=1.0, params={"term_keys": keys})
    term = mdp.is_terminated_term(cfg, env)
    assert term(env, term_keys=keys).tolist() == expected
