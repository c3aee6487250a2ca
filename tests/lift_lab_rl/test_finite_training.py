"""A number that is infinite or NaN stops the training before the policy takes it, and the error names the term."""

import math
from types import SimpleNamespace

import gymnasium as gym
import pytest
import torch
from point_task import AgentCfg, PointEnv, with_algorithm

import lift_lab_tasks  # noqa: F401
from lift_lab.managers import ObservationTermCfg, RewardTermCfg
from lift_lab.utils.errors import LiftLabError
from lift_lab_rl.evaluation import evaluate
from lift_lab_rl.files import load_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_tasks.utils.hydra import compose

BAD = [math.inf, -math.inf, math.nan]


def tensors(value):
    if isinstance(value, dict):
        for entry in value.values():
            yield from tensors(entry)
    elif isinstance(value, torch.Tensor):
        yield value


def all_finite(state):
    return all(bool(tensor.isfinite().all()) for tensor in tensors(state))


class Cartpole:
    """Cartpoles of which one reads ``value`` once: as a reward or as an observation."""

    def __init__(self, kind, value, step, num_envs=4):
        def term(env):
            values = torch.zeros(env.num_envs)
            if getattr(env, "common_step_counter", 0) == step:
                values[3] = value
            return values if kind == "reward" else values[:, None]

        env_cfg, agent_cfg = compose(
            "Cartpole", "rsl_rl_cfg_entry_point", [f"env.scene.num_envs={num_envs}", "env.sim.device=cpu"]
        )
        if kind == "reward":
            env_cfg.rewards.bad = RewardTermCfg(func=term, weight=0.5)
        else:
            env_cfg.observations.policy.bad = ObservationTermCfg(func=term)
        agent_cfg.num_steps_per_env, agent_cfg.save_interval, agent_cfg.device = 8, 1, "cpu"
        self.env = RslRlVecEnvWrapper(gym.make("Cartpole", cfg=env_cfg))
        self.agent_cfg = agent_cfg

    def runner(self, folder):
        return LiftLabRunner(self.env, to_rsl_rl(self.agent_cfg, self.env.get_observations().keys()), folder, "cpu")


@pytest.fixture
def cartpole():
    made = []

    def make(*args, **kwargs):
        made.append(Cartpole(*args, **kwargs))
        return made[-1]

    yield make
    for task in made:
        task.env.close()


@pytest.mark.parametrize("value", BAD)
def test_a_reward_that_is_not_finite_is_named_and_the_last_checkpoint_is_whole(cartpole, tmp_path, value):
    runner = cartpole("reward", value, step=12).runner(tmp_path)
    kind = "NaN" if math.isnan(value) else "infinite"
    expected = f"iteration 2: reward term 'bad' is {kind} in environment 3 in step 4 of 8; the update was not made"
    with pytest.raises(LiftLabError) as caught:
        runner.learn(3)
    assert str(caught.value) == expected
    assert [path.name for path in tmp_path.glob("model_*.pt")] == ["model_1.pt"]
    saved = load_torch(tmp_path / "model_1.pt")
    assert all_finite(saved)
    now = runner.alg.save()
    for part in ("actor_state_dict", "critic_state_dict"):
        assert all(torch.equal(now[part][name], saved[part][name]) for name in saved[part])


def test_a_reward_of_an_episode_that_has_ended_since_is_named(cartpole, tmp_path):
    task = cartpole("reward", math.inf, step=12)
    task.env.unwrapped.episode_length_buf[:] = task.env.unwrapped.max_episode_length - 14  # ends in step 14
    with pytest.raises(LiftLabError, match="reward term 'bad' is infinite in environment 3 in step 4 of 8"):
        task.runner(tmp_path).learn(3)


@pytest.mark.parametrize("step", [0, 4, 8])  # the last belongs to no transition of the first rollout
def test_an_observation_that_is_not_finite_is_named(cartpole, tmp_path, step):
    task = cartpole("observation", math.nan, step=step)
    if step == 0:
        task.env.reset()
    with pytest.raises(LiftLabError) as caught:
        task.runner(tmp_path).learn(3)
    where = f"in environment 3 after step {step} of 8"
    assert f"iteration 1: observation term 'bad' of group 'policy' is NaN {where}; " in str(caught.value)
    assert not list(tmp_path.glob("model_*.pt"))


def test_of_several_the_first_is_named_with_the_count_of_environments():
    env = PointEnv()
    runner = LiftLabRunner(env, to_rsl_rl(AgentCfg()))
    env.position[3], env.position[5] = math.nan, math.inf
    with pytest.raises(LiftLabError, match=r"'policy' is NaN in 2 environments \(the first is 3\) after step 0"):
        runner.learn(1)


def test_after_the_error_the_same_runner_goes_on():
    env = PointEnv()
    runner = LiftLabRunner(env, to_rsl_rl(AgentCfg()))
    env.position[3] = math.nan
    with pytest.raises(LiftLabError):
        runner.learn(1)
    env.position = torch.zeros(env.num_envs, 1)
    runner.learn(2)
    assert runner.current_learning_iteration == 2
    assert all_finite(runner.alg.save())


class Scaled(PointEnv):
    """Points whose observations or rewards are large but finite."""

    def __init__(self, observation=1.0, reward=1.0):
        super().__init__()
        self.observation, self.reward = observation, reward

    def get_observations(self):
        obs = super().get_observations()
        obs["policy"] = obs["policy"] * self.observation
        return obs

    def step(self, actions):
        obs, reward, done, extras = super().step(actions.clamp(-1.0, 1.0))
        return obs, reward * self.reward, done, extras


def changed(**algorithm):
    cfg = AgentCfg()
    cfg.policy.actor_obs_normalization = cfg.policy.critic_obs_normalization = False
    return with_algorithm(cfg, **algorithm)


@pytest.mark.parametrize(
    ("env", "cfg", "cause"),
    [
        (Scaled(observation=1e25), changed(), "observation group 'policy' is up to"),
        (Scaled(reward=1e25), changed(), "rewards are up to"),
        (Scaled(), changed(learning_rate=1e30, schedule="fixed"), "agent.algorithm.learning_rate is 1e[+]30"),
    ],
)
def test_an_update_that_overflows_is_taken_back_and_names_the_setting(env, cfg, cause):
    runner = LiftLabRunner(env, to_rsl_rl(cfg))
    before = {name: value.clone() for name, value in runner.alg.save()["actor_state_dict"].items()}
    with pytest.raises(LiftLabError, match=cause) as caught:
        runner.learn(5)
    assert "\n" not in str(caught.value)
    after = runner.alg.save()
    assert all_finite(after)
    if runner.current_learning_iteration == 0:
        assert all(torch.equal(after["actor_state_dict"][name], value) for name, value in before.items())


def test_the_look_changes_no_bit_of_a_training():
    states = []
    for check in (True, False):
        torch.manual_seed(5)
        cfg = AgentCfg()
        cfg.check_for_nan = check
        runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
        runner.learn(3)
        states.append(runner.alg.save())
    first, second = (list(tensors(state)) for state in states)
    assert len(first) == len(second) > 10
    assert all(torch.equal(a, b) for a, b in zip(first, second, strict=True))


# -- the other ways to run a policy


def test_an_evaluation_names_the_term(cartpole, monkeypatch):
    task = cartpole("reward", math.nan, step=5)
    probe = SimpleNamespace(first_step=torch.zeros(4, dtype=torch.long))
    monkeypatch.setattr(
        task.env.unwrapped.termination_manager, "get_term_cfg", lambda name: SimpleNamespace(func=probe)
    )
    with pytest.raises(LiftLabError, match=r"^reward term 'bad' is NaN in environment 3$"):
        evaluate(task.env, lambda obs: torch.zeros(4, 1), 4)


def test_the_wrapper_for_skrl_names_the_term(cartpole):
    pytest.importorskip("skrl")
    from lift_lab_rl.skrl import SkrlVecEnvWrapper

    wrapped = SkrlVecEnvWrapper(cartpole("observation", math.inf, step=1).env.env)
    wrapped.reset()
    with pytest.raises(LiftLabError, match=r"^observation term 'bad' of group 'policy' is infinite in environment 3$"):
        wrapped.step(torch.zeros(4, 1))


def test_the_wrapper_for_stable_baselines_names_the_term(cartpole):
    pytest.importorskip("stable_baselines3")
    from lift_lab_rl.sb3 import Sb3VecEnvWrapper

    wrapped = Sb3VecEnvWrapper(cartpole("reward", -math.inf, step=1).env.env)
    wrapped.reset()
    wrapped.step_async(torch.zeros(4, 1).numpy())
    with pytest.raises(LiftLabError, match=r"^reward term 'bad' is infinite in environment 3$"):
        wrapped.step_wait()
