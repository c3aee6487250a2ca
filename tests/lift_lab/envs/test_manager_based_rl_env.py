"""What one step of a reinforcement learning environment does, and in which order."""

import gymnasium as gym
import numpy as np
import pytest
import torch

import lift_lab.envs.mdp as mdp
from lift_lab.actuators import ActuatorNetMLPCfg, DelayedPDActuatorCfg, IdealPDActuatorCfg
from lift_lab.envs import ManagerBasedRLEnv
from lift_lab.envs.filming import update_markers
from lift_lab.managers import (
    CommandTerm,
    CommandTermCfg,
    CurriculumTermCfg,
    EventTermCfg,
    ObservationGroupCfg,
    ObservationTermCfg,
    RewardTermCfg,
    SceneEntityCfg,
    TerminationTermCfg,
)
from lift_lab.markers import VisualizationMarkers
from lift_lab.sim.ignored import pending_ignored
from lift_lab.utils import configclass
from lift_lab.utils.errors import ConfigError

ENGINES = ["native", pytest.param("warp", marks=pytest.mark.slow)]


def _still(env) -> torch.Tensor:
    return torch.zeros(env.num_envs, env.single_action_space.shape[0])


def _elbow_x(env):
    return env.scene["robot"].data.body_pos_w[:, 2, 0] - env.scene.env_origins[:, 0]


def _group(**terms) -> dict:
    """An observation config with one group ``policy``."""

    @configclass
    class _Policy(ObservationGroupCfg):
        pass

    group = _Policy()
    for name, term in terms.items():
        setattr(group, name, term)
    return {"policy": group}


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
        observations=_group(term=ObservationTermCfg(func=observation)),
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
    env.step(_still(env))
    assert calls == ["termination", "reward", "command update", "interval event", "observation"]
    calls.clear()
    env.step(_still(env))
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
        env.step(_still(env))
        if step == 2:
            env.reset(env_ids=[1])  # 3 steps are too few, though they are 12 of the physics
    env.reset(env_ids=[0, 2])
    assert seen == [(0, [0, 1, 2]), (20, [0, 2])]


# -- physics


def test_substeps_in_one_call_and_one_by_one_reach_the_same_state(make_env):
    results = []
    for fused in (True, False):
        env = make_env()
        assert env._actions_are_constant
        env._actions_are_constant = fused
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


# -- episodes


def test_an_episode_lasts_ceil_of_its_length_over_the_step(make_env):
    env = make_env(episode_length_s=0.13)
    assert env.step_dt == pytest.approx(0.02)
    assert env.max_episode_length == 7
    env.reset()
    lengths = []
    for _ in range(7):
        _, _, _, truncated, _ = env.step(_still(env))
        lengths.append((env.episode_length_buf[0].item(), truncated[0].item()))
    assert lengths == [(1, False), (2, False), (3, False), (4, False), (5, False), (6, False), (0, True)]
    assert env.common_step_counter == 7


def test_commands_last_for_the_time_that_steps_take(make_env):
    still = mdp.UniformPoseCommandCfg.Ranges(
        pos_x=(0.4, 0.4), pos_y=(0.0, 0.0), pos_z=(0.0, 0.0), roll=(0, 0), pitch=(0, 0), yaw=(0, 0)
    )
    goal = mdp.UniformPoseCommandCfg(
        asset_name="robot", body_name="lower", resampling_time_range=(0.05, 0.05), ranges=still
    )
    env = make_env(commands={"goal": goal})
    env.reset()
    counts = []
    for _ in range(6):
        env.step(_still(env))
        counts.append(env.command_manager.get_term("goal").command_counter.tolist())
    assert counts == [[1] * 3, [1] * 3, [2] * 3, [2] * 3, [2] * 3, [3] * 3]  # 50 ms end in the third step of 20 ms


def test_last_observations_are_of_the_step_that_ends_episodes_alone(make_env):
    env = make_env()
    env.wants_final_obs = True
    env.reset()
    env.episode_length_buf[1] = env.max_episode_length - 1
    assert ["final_obs" in env.step(_still(env))[-1] for _ in range(2)] == [True, False]


def test_the_log_holds_every_key_of_the_reset_environments(make_env):
    env = make_env(
        rewards={"alive": RewardTermCfg(func=mdp.is_alive, weight=3.0)},
        terminations={
            "time_out": TerminationTermCfg(func=mdp.time_out, time_out=True),
            "fast": TerminationTermCfg(func=mdp.joint_vel_out_of_manual_limit, params={"max_velocity": 1e3}),
        },
        curriculum={
            "alive": CurriculumTermCfg(
                func=mdp.modify_reward_weight, params={"term_name": "alive", "weight": 5.0, "num_steps": 100}
            )
        },
        commands={
            "goal": mdp.UniformPoseCommandCfg(
                asset_name="robot",
                body_name="lower",
                resampling_time_range=(5.0, 5.0),
                ranges=mdp.UniformPoseCommandCfg.Ranges(
                    pos_x=(0.4, 0.4), pos_y=(0.0, 0.0), pos_z=(0.0, 0.0), roll=(0, 0), pitch=(0, 0), yaw=(0, 0)
                ),
            )
        },
    )
    env.reset()
    for _ in range(10):
        *_, extras = env.step(_still(env))
    log = {key: float(value) for key, value in extras["log"].items()}
    assert set(log) == {
        "Episode_Reward/alive",
        "Episode_Termination/time_out",
        "Episode_Termination/fast",
        "Curriculum/alive",
        "Metrics/goal/position_error",
        "Metrics/goal/orientation_error",
        "Metrics/physics/nonfinite",
        "Metrics/physics/overflow",
    }
    assert log["Episode_Reward/alive"] == pytest.approx(3.0)
    assert log["Episode_Termination/time_out"] == 1.0
    assert log["Curriculum/alive"] == 3.0
    assert env.cfg.rewards["alive"].weight == 3.0


def test_only_the_named_environments_are_reset(make_env):
    env = make_env()
    env.reset()
    for _ in range(3):
        before, *_ = env.step(torch.ones(3, 2))
    default = env.scene["robot"].data.default_joint_pos
    obs, _ = env.reset(env_ids=[2])
    assert env.episode_length_buf.tolist() == [3, 3, 0]
    torch.testing.assert_close(obs["policy"][2, :2], default[2])
    torch.testing.assert_close(obs["policy"][:2, :2], before["policy"][:2, :2])


def test_a_partial_reset_leaves_the_others_histories_delays_and_timers_alone(make_env, make_cfg):
    def run(ends: bool):
        fired = []

        def note(env, env_ids):
            fired.append((env.common_step_counter, env_ids.tolist()))

        def end(env):
            return torch.tensor([False, False, ends and env.common_step_counter == 3])

        cfg = make_cfg(
            observations=_group(
                joint_pos=ObservationTermCfg(func=mdp.joint_pos, history_length=3),
                effort=ObservationTermCfg(func=mdp.joint_effort),
            ),
            events={
                "default": EventTermCfg(func=mdp.reset_scene_to_default, mode="reset"),
                "note": EventTermCfg(func=note, mode="interval", interval_range_s=(0.1, 0.1)),
            },
            terminations={"end": TerminationTermCfg(func=end)},
        )
        cfg.scene.robot.actuators = {
            "all": DelayedPDActuatorCfg(
                joint_names_expr=[".*"], stiffness=50.0, damping=5.0, effort_limit=50.0, min_delay=6, max_delay=6
            )
        }
        env = make_env(cfg=cfg)
        env.reset(seed=1)
        generator = torch.Generator().manual_seed(4)
        seen = [env.step(torch.rand(3, 2, generator=generator))[0]["policy"].clone() for _ in range(8)]
        return torch.stack(seen), fired, env.scene["robot"].data.default_joint_pos[2]

    whole, fired_whole, _ = run(ends=False)
    parted, fired_parted, default = run(ends=True)
    assert torch.equal(parted[:, :2], whole[:, :2])
    assert torch.equal(parted[:2, 2], whole[:2, 2])
    torch.testing.assert_close(parted[2, 2, :6], default.repeat(3))  # the first value after a reset fills the history
    assert fired_whole == [(5, [0, 1, 2])]
    assert fired_parted == [(5, [0, 1]), (7, [2])]  # its timer began again at step 3


@pytest.mark.parametrize("physics", ENGINES)
def test_every_episode_starts_with_the_lag_of_its_actuators(make_env, make_cfg, physics):
    """Lag 3, two steps of four physics steps an episode: after reset() and after a reset within a step alike."""
    cfg = make_cfg(physics=physics, episode_length_s=0.04)
    cfg.scene.robot.actuators = {
        "all": DelayedPDActuatorCfg(
            joint_names_expr=[".*"], stiffness=50.0, damping=0.0, effort_limit=1e3, min_delay=3, max_delay=3
        )
    }
    env = make_env(cfg=cfg)
    env.reset()
    actuator = env.scene["robot"].actuators["all"]
    compute, followed = actuator.compute, []

    def spy(action, joint_pos, joint_vel):
        given = compute(action, joint_pos, joint_vel)
        followed.append(float(given.joint_efforts[0, 0] / 50.0 + joint_pos[0, 0]))
        return given

    actuator.compute = spy
    for value in (1.0, 2.0, 3.0, 4.0):
        # at the start of an episode nothing was asked of the drives yet
        assert bool((env.scene["robot"].data.applied_torque == 0.0).all()) == (value in (1.0, 3.0))
        env.step(torch.full((3, 2), value))
    default = 0.3
    expected = [[default] * 3 + [default + 0.5 * value] * 4 + [default + 0.5 * (value + 1)] for value in (1.0, 3.0)]
    assert followed == pytest.approx([*expected[0], *expected[1]], abs=1e-5)


def _of_one(state: dict, index: int) -> dict:
    """A scene's state, of one environment alone."""
    return {key: _of_one(value, index) if isinstance(value, dict) else value[[index]] for key, value in state.items()}


class _Sum(torch.nn.Module):
    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return x.sum(dim=1)


@pytest.mark.parametrize("to_state", [False, True])
def test_a_reset_from_outside_leaves_the_actuators_of_the_others_alone(make_env, make_cfg, tmp_path, to_state):
    torch.jit.script(_Sum()).save(str(tmp_path / "sum.pt"))
    pd = {"stiffness": 50.0, "damping": 5.0, "effort_limit": 50.0}
    net = {"pos_scale": 5.0, "vel_scale": -0.1, "torque_scale": 1.0, "input_order": "pos_vel", "input_idx": [0, 2]}

    def run(resets: bool):
        cfg = make_cfg()
        cfg.scene.robot.actuators = {
            "late": DelayedPDActuatorCfg(joint_names_expr=["shoulder"], min_delay=6, max_delay=6, **pd),
            "net": ActuatorNetMLPCfg(
                joint_names_expr=["elbow"], network_file=str(tmp_path / "sum.pt"), saturation_effort=50.0, **net
            ),
        }
        env = make_env(cfg=cfg)
        env.reset(seed=1)
        generator = torch.Generator().manual_seed(4)
        seen = []
        for step in range(6):
            if resets and step == 3 and to_state:
                env.reset_to(_of_one(env.scene.get_state(), 2), [2])
            elif resets and step == 3:
                env.reset(env_ids=[2])
            seen.append(env.step(torch.rand(3, 2, generator=generator))[0]["policy"][:2].clone())
        return torch.stack(seen)

    assert torch.equal(run(resets=True), run(resets=False))


def test_reset_to_puts_environments_into_a_recorded_state(make_env, elbow_position):
    env = make_env()
    env.reset()
    for _ in range(3):
        env.step(torch.ones(3, 2))
    state = env.scene.get_state(is_relative=True)
    joints = state["articulation"]["robot"]["joint_position"]
    env.reset()
    obs, _ = env.reset_to(state, None, is_relative=True)
    torch.testing.assert_close(obs["policy"][:, :2], joints)
    torch.testing.assert_close(obs["policy"][:, 16:19], elbow_position(joints), atol=1e-5, rtol=0)


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
    observations = _group(
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


# -- spaces and config


def test_spaces_follow_the_groups_and_their_terms(make_env):
    observations = _group(
        joints=ObservationTermCfg(func=mdp.joint_pos, clip=(-2.0, 3.0)),
        actions=ObservationTermCfg(func=mdp.last_action),
    )
    observations["critic"] = observations["policy"].copy()
    observations["policy"].concatenate_terms = False
    env = make_env(observations=observations)
    policy, critic = env.single_observation_space["policy"], env.single_observation_space["critic"]
    assert policy["joints"] == gym.spaces.Box(-2.0, 3.0, (2,))
    assert policy["actions"] == gym.spaces.Box(-np.inf, np.inf, (2,))
    assert critic.shape == (4,)
    assert env.single_action_space.shape == (2,)
    assert env.observation_space["critic"].shape == (3, 4)
    assert env.action_space.shape == (3, 2)
    obs, _ = env.reset()
    assert obs["policy"]["joints"].shape == (3, 2)


def test_gymnasium_makes_the_environment_from_an_entry_point(make_cfg):
    name = "Test-Arm-v0"
    gym.register(id=name, entry_point="lift_lab.envs:ManagerBasedRLEnv", disable_env_checker=True)
    try:
        env = gym.make(name, cfg=make_cfg())
        assert isinstance(env.unwrapped, ManagerBasedRLEnv)
        assert env.unwrapped.metadata["render_fps"] == pytest.approx(50.0)
        env.reset(seed=1)
        obs, reward, terminated, truncated, _ = env.step(torch.zeros(3, 2))
        assert obs["policy"].shape[0] == reward.shape[0] == terminated.shape[0] == truncated.shape[0] == 3
        assert env.render() is None
        env.close()
    finally:
        gym.registry.pop(name)


def test_missing_values_are_listed_by_path(make_cfg):
    cfg = make_cfg()
    cfg.decimation = type(cfg)().__class__.__dataclass_fields__["decimation"].default
    cfg.scene.env_spacing = cfg.decimation
    with pytest.raises(TypeError, match=r"(?s)decimation.*scene\.env_spacing"):
        ManagerBasedRLEnv(cfg)


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("decimation", 0, "decimation must be at least 1"),
        ("episode_length_s", 0.0, "episode_length_s must be positive"),
    ],
)
def test_a_setting_that_cannot_work_is_an_error(make_cfg, field, value, message):
    with pytest.raises(ConfigError, match=message):
        ManagerBasedRLEnv(make_cfg(**{field: value}))


def test_an_unknown_render_mode_is_an_error(make_cfg):
    with pytest.raises(ConfigError, match="rgb_array"):
        ManagerBasedRLEnv(make_cfg(), render_mode="rgb")


@pytest.mark.parametrize(
    ("fields", "feature"),
    [
        ({"observations": _group(image=ObservationTermCfg(func=mdp.image))}, "mdp.image needs images"),
        (
            {"rewards": {}, "events": {"e": EventTermCfg(func=mdp.randomize_rigid_body_scale, mode="prestartup")}},
            "one model",
        ),
        (
            {
                "events": {
                    "e": EventTermCfg(func=mdp.reset_root_state_from_terrain, mode="reset", params={"pose_range": {}})
                }
            },
            "terrain",
        ),
    ],
)
def test_a_term_of_a_missing_feature_names_the_feature(make_cfg, fields, feature):
    cfg = make_cfg(**fields)

    def run():
        ManagerBasedRLEnv(cfg).reset()

    with pytest.raises(ConfigError, match=feature):
        run()


def test_settings_without_effect_are_noted(make_env, monkeypatch):
    from lift_lab.sim import ignored

    monkeypatch.setattr(ignored, "_reported", set())
    noted = {}
    monkeypatch.setattr("lift_lab.envs.manager_based_env.report_ignored", lambda: noted.update(pending_ignored()))
    make_env(num_rerenders_on_reset=2, wait_for_textures=False)
    assert {"num_rerenders_on_reset", "wait_for_textures"} <= set(noted)
    assert "xr" not in noted


def test_closing_twice_is_closing_once(make_cfg):
    env = ManagerBasedRLEnv(make_cfg())
    env.reset()
    env.close()
    env.close()


def test_a_failed_construction_leaves_no_simulation_behind(make_cfg):
    from lift_lab.sim import SimulationContext

    bad = RewardTermCfg(func=mdp.joint_vel_l2, weight=1.0, params={"asset_cfg": SceneEntityCfg("robto")})
    with pytest.raises(ConfigError, match="robot"):
        ManagerBasedRLEnv(make_cfg(rewards={"bad": bad}))
    assert SimulationContext.instance() is None


def test_printing_shows_every_manager(make_env):
    text = str(make_env())
    for manager in ("Event", "Recorder", "Action", "Observation", "Command", "Termination", "Reward", "Curriculum"):
        assert f"{manager}Manager" in text


# -- what callers do


def test_an_action_with_a_gradient_is_taken_and_lets_none_in(make_env):
    env = make_env(rewards={"rate": RewardTermCfg(func=mdp.action_rate_l2, weight=-1.0)})
    obs, _ = env.reset()
    network = torch.nn.Linear(obs["policy"].shape[1], 2)
    obs, reward, *_ = env.step(network(obs["policy"]))
    assert not reward.requires_grad
    assert not env.reset()[0]["policy"].requires_grad
    assert not obs["policy"].requires_grad


def test_a_mask_is_no_list_of_environments(make_env):
    env = make_env()
    env.reset()
    with pytest.raises(ConfigError, match="ids must be integers"):
        env.reset(env_ids=torch.tensor([False, False, True]))


@pytest.mark.parametrize("physics", ENGINES)
def test_what_an_interval_event_moved_is_observed_at_once(make_env, physics):
    """Bodies as joints: the observation after the event is that of a refreshed simulation."""

    def jump(env, env_ids):
        robot = env.scene["robot"]
        position = robot.data.joint_pos[env_ids] + 0.5
        robot.write_joint_state_to_sim(position, torch.zeros_like(position), env_ids=env_ids)

    events = {"jump": EventTermCfg(func=jump, mode="interval", interval_range_s=(0.01, 0.01))}
    observations = _group(x=ObservationTermCfg(func=lambda env: _elbow_x(env)[:, None]))
    env = make_env(physics=physics, events=events, observations=observations)
    env.reset()
    observed = env.step(_still(env))[0]["policy"].clone()
    env.sim.forward()
    env.scene.update(0.0)
    torch.testing.assert_close(observed[:, 0], _elbow_x(env), atol=1e-6, rtol=0)


def test_each_of_two_environments_has_its_own_markers(make_env):
    cfgs = {"goal": mdp.UniformPoseCommandCfg(asset_name="robot", body_name="lower", resampling_time_range=(1.0, 1.0),
            debug_vis=True, ranges=mdp.UniformPoseCommandCfg.Ranges(pos_x=(0, 1), pos_y=(0, 1), pos_z=(0, 1),
            roll=(0, 0), pitch=(0, 0), yaw=(0, 0)))}  # fmt: skip
    first, second = make_env(commands=cfgs), make_env(commands=cfgs)
    for env in (first, second):
        env.reset()
    update_markers(first)
    assert len(VisualizationMarkers.of(first.sim)) == 2
    assert VisualizationMarkers.of(second.sim) == []
    second.close()
    update_markers(first)
