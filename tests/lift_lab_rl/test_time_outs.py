"""What a time limit cuts off an episode is stood for by a value: of the last observation, or the one before it."""

import gymnasium as gym
import pytest
import torch
from point_task import AgentCfg, PointEnv, with_algorithm
from rsl_rl.models import MLPModel, RNNModel
from rsl_rl.storage import RolloutStorage
from tensordict import TensorDict

import lift_lab_tasks  # noqa: F401
from lift_lab.utils.errors import ConfigError
from lift_lab_rl.files import load_torch
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl
from lift_lab_rl.rsl_rl.ppo import LiftLabPPO
from lift_lab_rl.rsl_rl.time_outs import final_values
from lift_lab_tasks.utils import load_cfg_from_registry, parse_env_cfg

pytestmark = pytest.mark.usefixtures("one_torch_thread")

NUM_ENVS, STEPS, OBS, ACTIONS, GAMMA = 6, 5, 4, 2, 0.9
ENGINES = ["native", pytest.param("warp", marks=pytest.mark.slow)]


def observations(generator):
    return {"policy": torch.randn(NUM_ENVS, OBS, generator=generator)}


def batch(obs):
    return TensorDict(obs, batch_size=[NUM_ENVS])


def make(form, recurrent=False, **settings):
    """PPO with a critic that is not zero."""
    torch.manual_seed(1)
    obs, groups = batch(observations(torch.Generator())), {"actor": ["policy"], "critic": ["policy"]}
    cls, shape = MLPModel, {"hidden_dims": (16, 8), "activation": "elu", "obs_normalization": not recurrent}
    if recurrent:
        cls, shape = RNNModel, {**shape, "rnn_type": "gru", "rnn_hidden_dim": 7}
    distribution = {"class_name": "GaussianDistribution", "init_std": 0.8, "std_type": "log"}
    actor = cls(obs, groups, "actor", ACTIONS, distribution_cfg=distribution, **shape)
    critic = cls(obs, groups, "critic", 1, **shape)
    storage = RolloutStorage("rl", NUM_ENVS, STEPS, obs, [ACTIONS])
    settings = {"gamma": GAMMA, "num_mini_batches": 2, **settings}
    return LiftLabPPO(actor, critic, storage, time_out_bootstrap=form, **settings)


def rollout(algorithm, seed=2):
    """A rollout of a random world; per step: observations, rewards, terminated, time-outs, last observations."""
    generator, steps = torch.Generator().manual_seed(seed), []
    torch.manual_seed(3)
    obs = observations(generator)
    with torch.inference_mode():
        for step in range(STEPS):
            algorithm.act(batch(obs))
            rewards = torch.randn(NUM_ENVS, generator=generator)
            ends = torch.rand(NUM_ENVS, 2, generator=generator) < 0.3
            time_outs, terminated = ends[:, 0] & (step > 0), ends[:, 1] & ~ends[:, 0]
            final, following = observations(generator), observations(generator)
            extras = {"time_outs": time_outs}
            if (time_outs | terminated).any():
                extras["final_obs"] = final
            algorithm.process_env_step(batch(following), rewards, (time_outs | terminated).long(), extras)
            steps.append((obs, rewards, terminated, time_outs, final))
            obs = following
        algorithm.compute_returns(batch(obs))
    return steps


def values_along(algorithm, steps):
    """Values of each step's observation and, had it been the next one, of its last observation; the critic is fed one
    environment after the other, an episode from its start."""
    critic, before, after = algorithm.critic, torch.zeros(STEPS, NUM_ENVS), torch.zeros(STEPS, NUM_ENVS)
    with torch.no_grad():
        for env in range(NUM_ENVS):
            start = 0
            for step, (_, _, terminated, time_outs, _) in enumerate(steps):
                seen = [steps[k][0]["policy"][env] for k in range(start, step + 1)]
                for values, sequence in ((before, seen), (after, [*seen, steps[step][4]["policy"][env]])):
                    critic.reset(hidden_state=None)
                    for obs in sequence:
                        value = critic(TensorDict({"policy": obs[None]}, batch_size=[1]))
                    values[step, env] = value.item()
                if terminated[env] or time_outs[env]:
                    start = step + 1
    return before, after


@pytest.mark.parametrize("kind", ["micro-batches", "rsl_rl's update", "recurrent"])
@pytest.mark.parametrize("form", ["previous_obs", "final_obs"])
def test_an_episodes_last_return_is_its_reward_and_the_discounted_value_of_the_right_observation(form, kind):
    algorithm = make(form, recurrent=kind == "recurrent", use_mixed_precision=kind == "rsl_rl's update")
    assert (algorithm.micro_batches is not None) is (kind == "micro-batches")
    steps = rollout(algorithm)
    before, after = values_along(algorithm, steps)
    bootstrap = after if form == "final_obs" else before
    returns = algorithm.storage.returns[..., 0]
    counts = [0, 0]
    for step, (_, rewards, terminated, time_outs, _) in enumerate(steps):
        expected = rewards + GAMMA * bootstrap[step]
        torch.testing.assert_close(returns[step][time_outs], expected[time_outs], atol=1e-5, rtol=1e-5)
        torch.testing.assert_close(returns[step][terminated], rewards[terminated], atol=1e-5, rtol=1e-5)
        counts = [counts[0] + int(time_outs.sum()), counts[1] + int(terminated.sum())]
    assert min(counts) > 3
    assert (before - after).abs().max() > 0.01


def test_last_observations_of_other_environments_are_not_read():
    """They may be anything: a preview of a running episode, or not a number."""
    usual, odd = make("final_obs"), make("final_obs")
    for algorithm, fill in ((usual, 0.0), (odd, float("nan"))):
        with torch.inference_mode():
            for _ in range(STEPS):
                algorithm.act(batch(observations(torch.Generator().manual_seed(1))))
                time_outs = torch.arange(NUM_ENVS) == 2
                final = torch.where(time_outs[:, None], torch.ones(NUM_ENVS, OBS), torch.full((NUM_ENVS, OBS), fill))
                extras = {"time_outs": time_outs, "final_obs": {"policy": final}}
                next_obs = batch(observations(torch.Generator().manual_seed(1)))
                algorithm.process_env_step(next_obs, torch.ones(NUM_ENVS), time_outs.long(), extras)
            algorithm.compute_returns(next_obs)
    assert torch.isfinite(odd.storage.returns).all()
    assert torch.equal(usual.storage.returns, odd.storage.returns)


def test_values_on_a_device_are_computed_without_asking_it():
    """Tensors on torch's device ``meta`` have no numbers: whatever asks for one raises an error."""
    algorithm = make("final_obs")
    critic = algorithm.critic.to("meta")
    final, time_outs = torch.zeros(NUM_ENVS, OBS, device="meta"), torch.zeros(NUM_ENVS, 1, device="meta")
    assert final_values(critic, time_outs, {"policy": final}).shape == (NUM_ENVS, 1)


def test_a_runner_that_does_not_ask_for_last_observations_is_told_so():
    algorithm = make("final_obs")
    obs, ends = batch(observations(torch.Generator())), torch.ones(NUM_ENVS).bool()
    algorithm.act(obs)
    with pytest.raises(ConfigError, match="wants_final_obs = True"):
        algorithm.process_env_step(obs, torch.ones(NUM_ENVS), ends.long(), {"time_outs": ends})


# -- with an environment


def cartpole(engine="native", num_envs=8, length=7, finite=False):
    cfg = parse_env_cfg("Cartpole", device="cpu", num_envs=num_envs)
    cfg.seed, cfg.sim.num_threads, cfg.sim.physics = 3, 1, engine
    cfg.episode_length_s, cfg.is_finite_horizon = length * cfg.decimation * cfg.sim.dt, finite
    return RslRlVecEnvWrapper(gym.make("Cartpole", cfg=cfg))


def agent(form):
    cfg = load_cfg_from_registry("Cartpole", "rsl_rl_cfg_entry_point")
    cfg.algorithm.time_out_bootstrap, cfg.save_interval = form, 1
    return to_rsl_rl(cfg)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_environments_last_observation_is_the_one_that_is_valued(engine):
    env = cartpole(engine)
    runner = LiftLabRunner(env, agent("final_obs"))
    seen, step = [], env.step

    def spy(actions):
        obs, rewards, dones, extras = step(actions)
        extras = dict(extras)
        seen.append((rewards.clone(), extras["time_outs"].clone(), extras.get("final_obs")))
        return obs, rewards, dones, extras

    returns, update = [], runner.alg.update
    runner.alg.update = lambda: (returns.append(runner.alg.storage.returns.clone()), values(), update())[-1]
    expected = []

    def values():
        for k, (rewards, time_outs, final) in enumerate(seen):
            if time_outs.any():
                with torch.no_grad():
                    value = runner.alg.critic(TensorDict(final, batch_size=[8]))[:, 0]
                expected.append((k, time_outs, rewards + runner.alg.gamma * value))

    env.step = spy
    assert runner.learn(1)
    assert len(expected) == 2  # 16 steps hold two episodes of 7
    for k, time_outs, right in expected:
        torch.testing.assert_close(returns[0][k, :, 0][time_outs], right[time_outs], atol=1e-5, rtol=1e-5)
    assert env.unwrapped.wants_final_obs is False  # an evaluation afterwards draws no noise for them
    env.close()


def test_a_run_is_repeatable_and_continues_exactly(tmp_path):
    ends = []
    for folder, iterations in (("a", [4]), ("b", [4]), ("c", [2, 2])):
        checkpoint = None
        for count in iterations:
            env = cartpole()
            runner = LiftLabRunner(env, agent("final_obs"), tmp_path / folder)
            if checkpoint is not None:
                runner.load(str(checkpoint))
                assert "continuing the episodes" in runner.load_resume_state(checkpoint)
            runner.learn(count)
            checkpoint = tmp_path / folder / f"model_{runner.current_learning_iteration}.pt"
            env.close()
        ends.append(load_torch(checkpoint)["critic_state_dict"])
    for other in ends[1:]:
        assert all(torch.equal(value, other[name]) for name, value in ends[0].items())


def test_an_environment_that_cannot_give_last_observations_is_refused():
    cfg = AgentCfg()
    cfg.algorithm.time_out_bootstrap = "final_obs"
    with pytest.raises(ConfigError, match="PointEnv does not give the last observations of episodes"):
        LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    env = cartpole(finite=True)
    with pytest.raises(ConfigError, match="no effect on a task with a finite horizon"):
        LiftLabRunner(env, agent("final_obs"))
    env.close()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"time_out_bootstrap": "final"}, "no time_out_bootstrap 'final'; did you mean 'final_obs'"),
        ({"time_out_bootstrap": "final_obs", "class_name": "PPO"}, "'PPO' has none .*time_out_bootstrap=previous_obs"),
    ],
)
def test_a_form_that_could_not_work_is_refused(settings, message):
    cfg = with_algorithm(AgentCfg(), **settings)
    with pytest.raises(ConfigError, match=message):
        to_rsl_rl(cfg)
