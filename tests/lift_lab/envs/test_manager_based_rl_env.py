"""What one step of a reinforcement learning environment does, and in which order."""

import numpy as np
import pytest
import torch
from env_parts import group_of, zero_action

import lift_lab.envs.mdp as mdp
from lift_lab.actuators import IdealPDActuatorCfg
from lift_lab.managers import (
    CommandTerm,
    CommandTermCfg,
    CurriculumTermCfg,
    EventTermCfg,
    ObservationTermCfg,
    RewardTermCfg,
    SceneEntityCfg,
    TerminationTermCfg,
)

ENGINES = ["native", pytest.param("warp", marks=pytest.mark.slow)]


def _elbow_x(env):
    return env.scene["robot"].data.body_pos_w[:, 2, 0] - env.scene.env_origins[:, 0]


# -- order


def test_a_step_with_a_reset_calls_everything_in_the_documented_order(make_env):
    calls = []

    def termination(env):
        calls.append("termination")
        return env.episode_length_buf >= 2

    def reward(env):
        calls.append("reward")
        return torch.ones(env.num_envs)

    def curriculum(env, env_ids):
        calls.append("curriculum")

    def reset_event(env, env_ids):
        calls.append("reset event")

    def interval_event(env, env_ids):
        calls.append("interval event")

    def observation(env):
        calls.append("observation")
        return torch.zeros(env.num_envs, 1)

    class _Command(CommandTerm):
        @property
        def command(self):
            return torch.zeros(self.num_envs, 1)

        def _update_metrics(self):
            calls.append("command update")

        def _resample_command(self, env_ids):
            calls.append("command draw")

        def _update_command(self):
            pass

    env = make_env(
        observations=group_of(term=ObservationTermCfg(func=observation)),
        terminations={"term": TerminationTermCfg(func=termination)},
        rewards={"term": RewardTermCfg(func=reward, weight=1.0)},
        curriculum={"term": CurriculumTermCfg(func=curriculum)},
        commands={"term": CommandTermCfg(class_type=_Command, resampling_time_range=(100.0, 100.0))},
        events={
            "reset": EventTermCfg(func=reset_event, mode="reset"),
            "interval": EventTermCfg(
                func=interval_event, mode="interval", interval_range_s=(0.0, 0.0), is_global_time=True
            ),
        },
    )
    env.reset()
    calls.clear()
    env.step(zero_action(env))
    assert calls == ["termination", "reward", "command update", "interval event", "observation"]
    calls.clear()
    env.step(zero_action(env))
    assert calls == [
        "termination",
        "reward",
        "curriculum",
        "reset event",
        "command draw",
        "command update",
        "interval event",
        "observation",
    ]


@pytest.mark.parametrize("physics", ENGINES)
def test_rewards_read_the_kinematics_of_the_state_just_reached(make_env, elbow_position, physics):
    rewards = {"x": RewardTermCfg(func=_elbow_x, weight=1.0)}
    env = make_env(physics=physics, rewards=rewards)
    env.reset()
    for _ in range(3):
        obs, reward, *_ = env.step(torch.ones(3, 2))
        reached = elbow_position(obs["policy"][:, :2])
        torch.testing.assert_close(reward, reached[:, 0] * env.step_dt, atol=1e-6, rtol=0)


@pytest.mark.parametrize("physics", ENGINES)
def test_the_first_observation_of_an_episode_is_of_its_own_state(make_env, elbow_position, physics):
    env = make_env(physics=physics)
    first, _ = env.reset()
    env.episode_length_buf[1] = 8
    env.step(torch.ones(3, 2))
    obs, _, terminated, truncated, _ = env.step(torch.ones(3, 2))
    assert truncated.tolist() == [False, True, False]
    assert not terminated.any()
    torch.testing.assert_close(obs["policy"][1], first["policy"][1], atol=1e-6, rtol=0)
    assert (obs["policy"][[0, 2], :2] - first["policy"][[0, 2], :2]).abs().max() > 0.01
    # columns 2.. are the poses of base, upper and lower, 7 each
    torch.testing.assert_close(obs["policy"][:, 16:19], elbow_position(obs["policy"][:, :2]), atol=1e-5, rtol=0)


def test_a_reset_event_sees_the_number_of_environment_steps(make_env):
    seen = []

    def note(env, env_ids):
        seen.append((env._sim_step_counter, env_ids.tolist()))

    event = EventTermCfg(func=note, mode="reset", min_step_count_between_reset=5)
    env = make_env(events={"note": event})
    env.reset()
    env.reset(env_ids=[0])
    for step in range(5):
        env.step(zero_action(env))
        if step == 2:
            env.reset(env_ids=[1])  # 3 steps are too few, though they are 12 of the physics
    env.reset(env_ids=[0, 2])
    assert seen == [(0, [0, 1, 2]), (20, [0, 2])]


@pytest.mark.parametrize("physics", ENGINES)
def test_what_an_interval_event_moved_is_observed_at_once(make_env, physics):
    """Bodies as joints: the observation after the event is that of a refreshed simulation."""

    def jump(env, env_ids):
        robot = env.scene["robot"]
        position = robot.data.joint_pos[env_ids] + 0.5
        robot.write_joint_state_to_sim(position, torch.zeros_like(position), env_ids=env_ids)

    events = {"jump": EventTermCfg(func=jump, mode="interval", interval_range_s=(0.01, 0.01))}
    observations = group_of(x=ObservationTermCfg(func=lambda env: _elbow_x(env)[:, None]))
    env = make_env(physics=physics, events=events, observations=observations)
    env.reset()
    observed = env.step(zero_action(env))[0]["policy"].clone()
    env.sim.forward()
    env.scene.update(0.0)
    torch.testing.assert_close(observed[:, 0], _elbow_x(env), atol=1e-6, rtol=0)


# -- physics


def test_substeps_in_one_call_and_one_by_one_reach_the_same_state(make_env):
    results = []
    for fused in (True, False):
        env = make_env()
        assert env._fuses_substeps
        env._fuses_substeps = fused
        obs, _ = env.reset()
        told_s, update = [], env.scene.update

        def spy(dt, told_s=told_s, update=update):
            told_s.append(dt)
            update(dt)

        env.scene.update = spy
        for step in range(5):
            obs, *_ = env.step(torch.full((3, 2), 0.3 * step))
        results.append(obs["policy"])
        assert told_s == pytest.approx([0.02] * 5 if fused else [0.005] * 20)  # the time that sensors count
        env.close()
    assert torch.equal(results[0], results[1])


def test_an_action_that_changes_between_substeps_is_applied_at_each(make_env):
    actions = {"joints": mdp.RelativeJointPositionActionCfg(asset_name="robot", joint_names=[".*"])}
    env = make_env(actions=actions)
    env.reset()
    targets = []
    robot = env.scene["robot"]
    step = env.sim.physics.step

    def spy(num_substeps):
        targets.append((num_substeps, robot.data.joint_pos_target[0, 0].item(), robot.data.joint_pos[0, 0].item()))
        step(num_substeps)

    env.sim.physics.step = spy
    env.step(torch.full((3, 2), 0.1))
    assert [count for count, _, _ in targets] == [1, 1, 1, 1]
    for _, target, position in targets:
        assert target == pytest.approx(position + 0.1, abs=1e-6)
    assert len({position for _, _, position in targets}) == 4


@pytest.mark.parametrize("physics", ENGINES)
def test_an_environment_whose_physics_fails_is_reset_without_reward(make_env, physics):
    env = make_env(physics=physics, rewards={"alive": RewardTermCfg(func=mdp.is_alive, weight=1.0)})
    healthy = make_env(physics=physics, rewards={"alive": RewardTermCfg(func=mdp.is_alive, weight=1.0)})
    first, _ = env.reset()
    healthy.reset()
    env.episode_length_buf[1] = env.max_episode_length - 1  # its time is up in the same step
    env.sim.physics.write("qvel", float("nan"), torch.tensor([1]))
    action = torch.full((3, 2), 0.4)
    obs, reward, terminated, truncated, extras = env.step(action)
    expected, *_ = healthy.step(action)
    assert terminated.tolist() == env.physics_failed.tolist() == [False, True, False]
    assert not truncated.any()
    torch.testing.assert_close(reward, torch.tensor([0.02, 0.0, 0.02]))
    assert extras["log"]["Metrics/physics/nonfinite"] == 1.0
    assert extras["log"]["Metrics/physics/overflow"] == 0.0
    assert all(np.isfinite(float(value)) for value in extras["log"].values())
    torch.testing.assert_close(obs["policy"][1], first["policy"][1], atol=1e-6, rtol=0)
    torch.testing.assert_close(obs["policy"][[0, 2]], expected["policy"][[0, 2]])
    # the next step is as healthy as any other
    obs, reward, terminated, *_ = env.step(action)
    assert not terminated.any()
    torch.testing.assert_close(obs["policy"][1], expected["policy"][1])
    env.episode_length_buf[0] = env.max_episode_length - 1
    *_, extras = env.step(action)
    assert extras["log"]["Metrics/physics/nonfinite"] == 0.0  # a failure is logged once


@pytest.mark.parametrize("physics", ENGINES)
def test_an_action_of_nan_ends_that_environments_episode_alone(make_env, make_cfg, physics):
    cfg = make_cfg(physics=physics, rewards={"action": RewardTermCfg(func=mdp.action_l2, weight=1.0)})
    cfg.scene.robot.actuators = {
        "all": IdealPDActuatorCfg(joint_names_expr=[".*"], stiffness=50.0, damping=5.0, effort_limit=50.0)
    }  # computed in each of the four physics steps, so that it fails in each
    env = make_env(cfg=cfg)
    env.reset()
    action = torch.full((3, 2), 0.5)
    env.step(action)
    action[2] = float("nan")
    obs, reward, terminated, _, extras = env.step(action)
    assert terminated.tolist() == [False, False, True]
    assert torch.isfinite(obs["policy"]).all()
    torch.testing.assert_close(reward, torch.tensor([0.01, 0.01, 0.0]))
    log = {name: float(value) for name, value in extras["log"].items()}
    assert log["Metrics/physics/nonfinite"] == 1.0
    # 2 * 0.25 for 20 ms, of the step before alone, over 0.2 s
    assert log["Episode_Reward/action"] == pytest.approx(0.05)
    torch.testing.assert_close(env.reward_manager.episode_sum("action"), torch.tensor([0.02, 0.02, 0.0]))
    env.sim.physics.write("qvel", float("nan"), torch.tensor([1]))  # this one fails in the first physics step alone
    _, _, terminated, *_ = env.step(action)
    assert terminated.tolist() == [False, True, True]


# -- repeatability


def _random_run(make_env, seed, **kwargs):
    throw = EventTermCfg(
        func=mdp.reset_root_state_uniform,
        mode="reset",
        params={
            "pose_range": {"x": (-1.0, 1.0), "yaw": (-1.0, 1.0)},
            "velocity_range": {"y": (-1.0, 1.0)},
            "asset_cfg": SceneEntityCfg("ball"),
        },
    )
    push = EventTermCfg(
        func=mdp.push_by_setting_velocity,
        mode="interval",
        interval_range_s=(0.02, 0.06),
        params={"velocity_range": {"x": (-1.0, 1.0)}, "asset_cfg": SceneEntityCfg("ball")},
    )
    observations = group_of(
        pos=ObservationTermCfg(func=mdp.root_pos_w, params={"asset_cfg": SceneEntityCfg("ball")}),
        joints=ObservationTermCfg(func=mdp.joint_pos),
    )
    env = make_env(seed=seed, observations=observations, events={"throw": throw, "push": push}, **kwargs)
    env.reset()
    trace = [env.step(torch.randn(3, 2))[0]["policy"] for _ in range(15)]
    env.close()
    return torch.stack(trace)


@pytest.mark.parametrize("physics", ENGINES)
def test_the_same_seed_gives_the_same_run_to_the_bit(make_env, physics):
    first = _random_run(make_env, 3, physics=physics)
    assert torch.equal(first, _random_run(make_env, 3, physics=physics))
    assert not torch.equal(first, _random_run(make_env, 4, physics=physics))


def test_a_seed_given_to_reset_repeats_what_follows(make_env):
    throw = EventTermCfg(
        func=mdp.reset_joints_by_offset,
        mode="reset",
        params={"position_range": (-0.3, 0.3), "velocity_range": (-1.0, 1.0)},
    )
    env = make_env(events={"throw": throw})
    first, _ = env.reset(seed=11)
    other, _ = env.reset()
    again, _ = env.reset(seed=11)
    assert torch.equal(first["policy"], again["policy"])
    assert not torch.equal(first["policy"], other["policy"])


# -- what callers do


def test_an_action_with_a_gradient_is_taken_and_lets_none_in(make_env):
    env = make_env(rewards={"rate": RewardTermCfg(func=mdp.action_rate_l2, weight=-1.0)})
    obs, _ = env.reset()
    network = torch.nn.Linear(obs["policy"].shape[1], 2)
    obs, reward, *_ = env.step(network(obs["policy"]))
    assert not reward.requires_grad
    assert not env.reset()[0]["policy"].requires_grad
    assert not obs["policy"].requires_grad
