"""skrl sees an environment as Isaac Lab's, trains in it, and gets back what it saved."""

import copy

import gymnasium as gym
import pytest
import torch

pytest.importorskip("skrl", reason="skrl is not installed (the extra 'skrl')")

from skrl.trainers.torch import ParallelTrainer, SequentialTrainer, SequentialTrainerCfg, Trainer
from skrl.utils.runner.torch import Runner

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError
from lift_lab_rl.skrl import SkrlVecEnvWrapper
from lift_lab_rl.skrl_runs import load_agent
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg


@pytest.fixture
def make():
    """Makes a wrapped task; closed at the end."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    made = []

    def call(num_envs, task="Cartpole", seed=3, **settings):
        cfg = parse_env_cfg(task, device="cpu", num_envs=num_envs)
        cfg.seed, cfg.sim.num_threads = seed, 1
        for name, value in settings.items():
            setattr(cfg, name, value)
        made.append(SkrlVecEnvWrapper(gym.make(task, cfg=cfg)))
        return made[-1]

    yield call
    for env in made:
        env.close()
    torch.set_num_threads(threads)


def agent_cfg(task="Cartpole", rollouts=1, folder=None):
    cfg = load_cfg_from_registry(task, "skrl_cfg_entry_point")
    cfg["trainer"]["timesteps"] = rollouts * cfg["agent"]["rollouts"]
    experiment = cfg["agent"]["experiment"]
    experiment["write_interval"] = experiment["checkpoint_interval"] = 0
    return cfg


def mean_reward(agent, env, steps=300):
    """Reward a second over whole episodes of the policy without noise."""
    agent.enable_training_mode(False, apply_to_models=True)
    obs, _ = env._env.reset(seed=8)
    obs, total = obs["policy"], 0.0
    with torch.inference_mode():
        for step in range(steps):
            _, outputs = agent.act(obs, None, timestep=step, timesteps=steps)
            obs, rewards, *_ = env.step(outputs["mean_actions"])
            total += float(rewards.mean())
    return total / (steps * env.unwrapped.step_dt)


def test_spaces_are_those_of_one_environment(make):
    env = make(3)
    assert env.num_envs == 3
    assert env.observation_space.shape == (4,)
    assert env.action_space.shape == (1,)
    assert env.state_space is None
    obs, _ = env.reset()
    assert obs.shape == (3, 4)
    obs, rewards, terminated, truncated, _ = env.step(torch.zeros(3, 1))
    assert obs.shape == (3, 4)
    assert rewards.shape == terminated.shape == truncated.shape == (3, 1)


def test_random_numbers_follow_the_environments_seed(make):
    first, _ = make(4, seed=3).reset()
    again, _ = make(4, seed=3).reset()
    other, _ = make(4, seed=4).reset()
    assert torch.equal(first, again)
    assert not torch.equal(first, other)


def test_an_agent_may_change_rewards_in_place(make):
    env = make(2)
    env.reset()
    _, rewards, *_ = env.step(torch.zeros(2, 1))
    kept = env.unwrapped.reward_buf.clone()
    rewards += 7.0
    assert torch.equal(env.unwrapped.reward_buf, kept)


def test_the_end_of_a_finite_horizon_is_a_termination(make):
    for finite in (False, True):
        env = make(2, episode_length_s=1 / 60, is_finite_horizon=finite)
        env.reset()
        _, _, terminated, truncated, _ = env.step(torch.zeros(2, 1))
        assert bool(terminated.all()) is finite
        assert bool(truncated.all()) is not finite


@pytest.mark.parametrize(("more", "message"), [({"ml_framework": "jax"}, "'torch'"), ({"wrapper": "gym"}, "'gym'")])
def test_other_frameworks_and_wrappers_are_refused(make, more, message):
    env = make(1)
    with pytest.raises(ConfigError, match=message):
        SkrlVecEnvWrapper(env._env, **more)


def test_the_cart_pole_is_learned_and_comes_back_from_its_file(make, tmp_path):
    env = make(128)
    cfg = agent_cfg(rollouts=60)
    runner = Runner(env, cfg)
    before = mean_reward(runner.agent, env)
    runner.run()
    runner.agent.save(str(tmp_path / "agent.pt"))
    after = mean_reward(runner.agent, env)
    assert before < -1.0  # the pole hangs
    assert after > 0.5  # at most 1: alive, upright and still

    loaded = Runner(env, copy.deepcopy(cfg)).agent
    load_agent(loaded, tmp_path / "agent.pt")
    assert mean_reward(loaded, env) == after


def test_the_lift_task_trains_with_normalised_observations(make, tmp_path):
    env = make(2, task="Lift-Cube-Franka")
    runner = Runner(env, agent_cfg("Lift-Cube-Franka", rollouts=2))
    weights = [parameter.clone() for parameter in runner.agent.policy.parameters()]
    runner.run()
    assert any(not torch.equal(a, b) for a, b in zip(weights, runner.agent.policy.parameters(), strict=True))
    runner.agent.save(str(tmp_path / "agent.pt"))
    saved = torch.load(tmp_path / "agent.pt", weights_only=True)
    assert saved["observation_preprocessor"]["running_mean"].shape == (36,)


def test_an_agent_that_a_file_does_not_fit_stays_as_it_is(make, tmp_path):
    env, cfg = make(2), agent_cfg()
    agent = Runner(env, cfg).agent
    agent.save(str(tmp_path / "agent.pt"))
    states = torch.load(tmp_path / "agent.pt", weights_only=True)
    before = {name: value.clone() for name, value in agent.policy.state_dict().items()}
    changed = copy.deepcopy(states)
    first = next(name for name in changed["policy"] if name.endswith("weight"))
    changed["policy"] = {name: value + 1.0 for name, value in changed["policy"].items()}
    changed["value"] = {**changed["value"], first: torch.zeros(1, 1)}
    without = {name: state for name, state in states.items() if name != "optimizer"}
    for content, message in (
        (changed, "does not fit this agent: Error"),
        ({**states, "other": {}}, "this agent lacks 'other'"),
        ({**without, "optimizer": {}}, "does not fit this agent"),
        ({name: state for name, state in states.items() if name != "value"}, "the file lacks 'value'"),
    ):
        torch.save(content, tmp_path / "agent.pt")
        with pytest.raises(ConfigError, match=message) as caught:
            load_agent(agent, tmp_path / "agent.pt")
        assert "\n" not in str(caught.value)
        assert all(torch.equal(value, before[name]) for name, value in agent.policy.state_dict().items())


# -- time limits

LENGTH = 5
"""Steps of an episode; a rollout has three."""


class Paying(SkrlVecEnvWrapper):
    """Pays more from the second episode on."""

    bonus = 0.0

    def step(self, actions):
        obs, rewards, *others = super().step(actions)
        return obs, rewards + self.bonus * (self.unwrapped.common_step_counter > LENGTH), *others


def learnt(make, bonus=0.0, **settings):
    """Memory of one rollout of the shipped settings, whose networks do not change, and the agent."""
    env = make(4, episode_length_s=LENGTH / 60)
    env.__class__, env.bonus = Paying, bonus
    cfg = agent_cfg()
    cfg["agent"].update(value_preprocessor=None, learning_rate=0.0, learning_rate_scheduler=None, **settings)
    runner = Runner(env, cfg)
    runner.run()
    memory = runner.agent.memory
    names = ("actions", "rewards", "truncated", "terminated", "returns")
    return {name: memory.get_tensor_by_name(name)[..., 0].clone() for name in names}, runner.agent


def test_the_shipped_files_ask_for_values_beyond_time_limits():
    for task in ("Cartpole", "Lift-Cube-Franka"):
        assert agent_cfg(task)["agent"]["time_limit_bootstrap"] is True


def test_a_return_at_a_time_limit_is_the_reward_and_the_value_of_the_last_observation(make):
    found, agent = learnt(make)
    assert found["truncated"].nonzero()[::4, 0].tolist() == [4, 9, 14]
    twin = make(4)  # the same random numbers, but its episodes go on
    twin.reset()
    for step in range(LENGTH):
        obs, rewards, *_ = twin.step(found["actions"][step, :, None])
    with torch.no_grad():
        value, _ = agent.value.act({"observations": obs}, role="value")
    expected = (rewards + agent.cfg.discount_factor * value)[:, 0]
    torch.testing.assert_close(found["returns"][LENGTH - 1], expected, atol=1e-6, rtol=1e-5)
    assert value.abs().min() > 1e-4


@pytest.mark.parametrize("bootstrap", [True, False])
def test_the_next_episodes_pay_changes_no_return_of_an_episode_that_a_time_limit_ended(make, bootstrap):
    plain, _ = learnt(make, time_limit_bootstrap=bootstrap)
    paid, _ = learnt(make, bonus=100.0, time_limit_bootstrap=bootstrap)
    assert torch.equal(plain["returns"][:LENGTH], paid["returns"][:LENGTH])
    assert (paid["returns"][LENGTH:] > plain["returns"][LENGTH:] + 50.0).all()
    if not bootstrap:
        torch.testing.assert_close(plain["returns"][LENGTH - 1], plain["rewards"][LENGTH - 1])


class Recorder:
    """As much of an agent as a trainer asks for."""

    cfg = None

    def init(self, trainer_cfg=None):
        pass

    def record_transition(self, **transition):
        self.transition = transition


def test_simultaneous_agents_get_the_last_observations_of_their_own_environments(make):
    env, agents = make(3, episode_length_s=1 / 60), [Recorder(), Recorder()]
    trainer = SequentialTrainer(
        cfg=SequentialTrainerCfg(close_environment_at_exit=False), env=env, agents=agents, scopes=[1, 2]
    )
    env.reset()
    obs, _, terminated, truncated, _ = env.step(torch.zeros(3, 1))
    assert truncated.all()
    last = env.final_observations[0]
    assert (last != obs).any(1).all()
    for agent, (first, end) in zip(agents, trainer.scopes, strict=True):
        rows = slice(first, end)
        agent.record_transition(
            next_observations=obs[rows], next_states=None, terminated=terminated[rows], truncated=truncated[rows]
        )
        assert torch.equal(agent.transition["next_observations"], last[rows])


def test_agents_in_other_processes_are_refused(make):
    trainer = object.__new__(ParallelTrainer)
    cfg = SequentialTrainerCfg(close_environment_at_exit=False)
    with pytest.raises(ConfigError, match="use SequentialTrainer"):
        Trainer.__init__(trainer, cfg=cfg, env=make(1), agents=Recorder())
