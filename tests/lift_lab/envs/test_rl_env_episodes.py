"""Episodes of a reinforcement learning environment: how long they last, and what a reset changes and leaves alone."""

import pytest
import torch
from env_parts import group_of, zero_action

import lift_lab.envs.mdp as mdp
from lift_lab.actuators import ActuatorNetMLPCfg, DelayedPDActuatorCfg
from lift_lab.managers import CurriculumTermCfg, EventTermCfg, ObservationTermCfg, RewardTermCfg, TerminationTermCfg
from lift_lab.utils.errors import ConfigError

ENGINES = ["native", pytest.param("warp", marks=pytest.mark.slow)]


def test_an_episode_lasts_ceil_of_its_length_over_the_step(make_env):
    env = make_env(episode_length_s=0.13)
    assert env.step_dt == pytest.approx(0.02)
    assert env.max_episode_length == 7
    env.reset()
    lengths = []
    for _ in range(7):
        _, _, _, truncated, _ = env.step(zero_action(env))
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
        env.step(zero_action(env))
        counts.append(env.command_manager.get_term("goal").command_counter.tolist())
    assert counts == [[1] * 3, [1] * 3, [2] * 3, [2] * 3, [2] * 3, [3] * 3]  # 50 ms end in the third step of 20 ms


def test_last_observations_are_of_the_step_that_ends_episodes_alone(make_env):
    env = make_env()
    env.wants_final_obs = True
    env.reset()
    env.episode_length_buf[1] = env.max_episode_length - 1
    assert ["final_obs" in env.step(zero_action(env))[-1] for _ in range(2)] == [True, False]


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
        *_, extras = env.step(zero_action(env))
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
            observations=group_of(
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
    net = {
        "pos_scale": 5.0,
        "vel_scale": -0.1,
        "torque_scale": 1.0,
        "input_order": "pos_vel",
        "input_idx": [0, 2],
        "velocity_limit": 1e9,
    }

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


def test_a_mask_is_no_list_of_environments(make_env):
    env = make_env()
    env.reset()
    with pytest.raises(ConfigError, match="ids must be integers"):
        env.reset(env_ids=torch.tensor([False, False, True]))
