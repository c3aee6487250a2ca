"""An update in micro-batches takes rsl_rl's steps up to rounding, with the same bits on any number of threads."""

import pytest
import torch
from rsl_rl.algorithms import PPO
from rsl_rl.models import MLPModel
from rsl_rl.storage import RolloutStorage
from tensordict import TensorDict

from lift_lab.utils.errors import ConfigError
from lift_lab_rl.rsl_rl.ppo import LiftLabPPO

pytestmark = pytest.mark.usefixtures("one_torch_thread")

NUM_ENVS, STEPS, OBS, ACTIONS = 64, 6, 5, 3


def make(cls, *, std_type="log", activation="elu", normalise=(True, True), rows=None, seed=0, **settings):
    torch.manual_seed(seed)
    obs = TensorDict({"policy": torch.zeros(NUM_ENVS, OBS)}, batch_size=[NUM_ENVS])
    groups = {"actor": ["policy"], "critic": ["policy"]}
    shape = {"hidden_dims": (16, 8), "activation": activation}
    distribution = {"class_name": "GaussianDistribution", "init_std": 0.8, "std_type": std_type}
    for_actor, for_critic = ({**shape, "obs_normalization": own} for own in normalise)
    actor = MLPModel(obs, groups, "actor", ACTIONS, distribution_cfg=distribution, **for_actor)
    critic = MLPModel(obs, groups, "critic", 1, **for_critic)
    storage = RolloutStorage("rl", NUM_ENVS, STEPS, obs, [ACTIONS])
    settings = {"learning_rate": 3e-3, "num_learning_epochs": 3, "num_mini_batches": 4, **settings}
    algorithm = cls(actor, critic, storage, **settings)
    if rows is not None:
        parts = algorithm.micro_batches
        parts.rows, parts.acting_rows, parts.block_rows = rows, rows, 7
    return algorithm


def rollouts(algorithm, count=2):
    """Rollouts of a random world, each followed by an update; returns the losses of the last."""
    torch.manual_seed(3)
    generator = torch.Generator().manual_seed(7)
    losses = {}
    obs = TensorDict({"policy": torch.randn(NUM_ENVS, OBS, generator=generator)}, batch_size=[NUM_ENVS])
    for _ in range(count):
        with torch.inference_mode():
            for _ in range(STEPS):
                actions = algorithm.act(obs)
                reward = obs["policy"][:, 0] - actions.square().sum(-1) * 0.1
                dones = (torch.rand(NUM_ENVS, generator=generator) < 0.2).long()
                time_outs = dones.bool() & (torch.rand(NUM_ENVS, generator=generator) < 0.5)
                noise = torch.randn(NUM_ENVS, OBS, generator=generator)
                obs = TensorDict({"policy": noise + 2.0}, batch_size=[NUM_ENVS])
                algorithm.process_env_step(obs, reward, dones, {"time_outs": time_outs})
            algorithm.compute_returns(obs)
        losses = algorithm.update()
    return losses


def weights(algorithm):
    state = [*algorithm.actor.state_dict().values(), *algorithm.critic.state_dict().values()]
    return torch.cat([value.detach().double().flatten() for value in state])


def flipped(env, obs=None, actions=None):
    """Each sample and its image: numbers change places and signs, and one action has an offset."""
    if obs is not None:
        image = obs["policy"][:, [1, 0, 2, 3, 4]] * torch.tensor([1.0, 1.0, -1.0, 1.0, -1.0])
        obs = torch.cat([obs, TensorDict({"policy": image}, batch_size=obs.batch_size)])
    if actions is not None:
        actions = torch.cat([actions, actions * torch.tensor([-1.0, 1.0, -1.0]) + torch.tensor([0.3, 0.0, 0.0])])
    return obs, actions


def turned(env, obs=None, actions=None):
    """Four of each sample, as of a body with four equal sides."""
    quarter = [1, 2, 3, 0, 4]
    if obs is not None:
        images = [obs["policy"]]
        for _ in range(3):
            images.append(images[-1][:, quarter])
        obs = TensorDict({"policy": torch.cat(images)}, batch_size=[4 * len(obs)])
    if actions is not None:
        actions = torch.cat([actions, actions.roll(1, 1), actions.roll(2, 1), -actions])
    return obs, actions


def symmetric(func=flipped, augment=True, loss=False):
    """Settings of rsl_rl's symmetry extension."""
    cfg = {"data_augmentation_func": func, "use_data_augmentation": augment, "use_mirror_loss": loss}
    return {"symmetry_cfg": {**cfg, "mirror_loss_coeff": 0.7, "env": None}}


@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"std_type": "scalar", "use_clipped_value_loss": False},
        {"activation": "tanh", "normalize_advantage_per_mini_batch": True},
        {"schedule": "fixed", "entropy_coef": 0.0, "desired_kl": None},
        {"optimizer": "sgd", "normalise": (False, False)},
        {"optimizer": "adamw", "normalise": (False, True)},
        symmetric(),
        {**symmetric(loss=True), "activation": "tanh", "normalize_advantage_per_mini_batch": True},
        {**symmetric(augment=False, loss=True), "normalise": (False, True)},
        symmetric(augment=False),
        {**symmetric(turned, loss=True), "schedule": "fixed", "optimizer": "sgd"},
        symmetric(turned, augment=False, loss=True),
    ],
    ids=[
        "elu",
        "scalar std, plain value loss",
        "tanh, advantages by minibatch",
        "fixed rate",
        "sgd",
        "adamw",
        "mirrored samples",
        "mirrored samples, mirror loss, tanh, advantages by minibatch",
        "mirror loss, one normalisation",
        "mirror loss in the log",
        "four copies, mirror loss, sgd",
        "four copies, only the mirror loss",
    ],
)
def test_an_update_ends_where_rsl_rl_ends(settings):
    # One rollout: rsl_rl draws (unused) actions while it learns, so that its later rollouts see other noise.
    theirs, ours = make(PPO, **settings), make(LiftLabPPO, rows=20, num_threads=2, **settings)
    their_losses, our_losses = rollouts(theirs, 1), rollouts(ours, 1)
    torch.testing.assert_close(weights(ours), weights(theirs), atol=2e-5, rtol=1e-4)
    assert ours.learning_rate == theirs.learning_rate
    for key, value in their_losses.items():
        assert our_losses[key] == pytest.approx(value, abs=1e-4, rel=1e-4)


def doubled(env, obs=None, actions=None):
    """Images that are the samples themselves."""
    return (None if obs is None else torch.cat([obs, obs])), (None if actions is None else actions.repeat(2, 1))


@pytest.mark.parametrize("augment", [True, False])
def test_images_that_are_the_samples_change_nothing_with_all_our_parts_on(augment):
    parts = {"mean_reg_coef": 0.1, "advantage_clip": 0.5, "gamma_final": 0.5, "anneal_iterations": (0, 2)}
    with_images = make(LiftLabPPO, rows=20, num_threads=2, **parts, **symmetric(doubled, augment=augment, loss=True))
    without = make(LiftLabPPO, rows=20, num_threads=2, **parts)
    found, expected = rollouts(with_images), rollouts(without)
    torch.testing.assert_close(weights(with_images), weights(without), atol=2e-5, rtol=1e-4)
    assert found.pop("symmetry") == pytest.approx(0.0, abs=1e-9)
    assert found == pytest.approx(expected, abs=1e-4, rel=1e-4)


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda env, obs, actions: (obs, actions), "expected the given samples and after them their images"),
        (lambda env, obs, actions: (torch.cat([obs, obs]), actions), "expected the given samples and after them"),
        (lambda env, obs, actions: (torch.cat([obs, obs]), -actions.repeat(2, 1) - 1.0), "are not the given ones"),
    ],
    ids=["no images", "no images of the actions", "images first"],
)
def test_a_function_that_returns_something_else_is_refused(function, message):
    with pytest.raises(ConfigError, match=message):
        make(LiftLabPPO, **symmetric(function))


def test_a_critic_that_normalises_otherwise_than_the_actor_goes_on_doing_so():
    theirs, ours = make(PPO), make(LiftLabPPO)
    for algorithm in (theirs, ours):
        algorithm.critic.obs_normalizer._mean += 1.0
        algorithm.critic.obs_normalizer.count += 500
        rollouts(algorithm, 1)
    assert not torch.equal(ours.critic.obs_normalizer._mean, ours.actor.obs_normalizer._mean)
    torch.testing.assert_close(weights(ours), weights(theirs), atol=2e-5, rtol=1e-4)


@pytest.mark.parametrize("settings", [{}, symmetric(loss=True)], ids=["plain", "symmetry"])
@pytest.mark.parametrize("threads", [2, 3, 8])
def test_the_number_of_threads_does_not_change_a_bit(threads, settings):
    one, many = (make(LiftLabPPO, rows=17, num_threads=count, **settings) for count in (1, threads))
    rollouts(one), rollouts(many)
    assert torch.equal(weights(one), weights(many))


def test_a_fixed_standard_deviation_stays_fixed():
    algorithm = make(LiftLabPPO)
    std = next(algorithm.actor.distribution.parameters())
    std.requires_grad_(False)
    before = std.clone()
    rollouts(algorithm)
    assert torch.equal(std, before)


def _mean_action_after_updates_without_reward(mean_reg_coef: float) -> tuple[float, float]:
    """Mean squared length of the mean action before and after two updates in a world where nothing matters."""
    settings = {"value_loss_coef": 0.0, "entropy_coef": 0.0, "gamma": 0.0, "schedule": "fixed", "desired_kl": None}
    algorithm = make(LiftLabPPO, mean_reg_coef=mean_reg_coef, learning_rate=1e-2, **settings)
    obs = TensorDict({"policy": torch.randn(NUM_ENVS, OBS)}, batch_size=[NUM_ENVS])
    lengths = []
    for _ in range(3):
        with torch.inference_mode():
            mean = algorithm.actor(obs)
            lengths.append(mean.square().sum(-1).mean().item())
            for _ in range(STEPS):
                algorithm.act(obs)
                algorithm.process_env_step(obs, torch.zeros(NUM_ENVS), torch.zeros(NUM_ENVS).long(), {})
            algorithm.compute_returns(obs)
            algorithm.storage.advantages.zero_()
        algorithm.update()
    return lengths[0], lengths[-1]


def test_the_mean_action_is_drawn_to_zero_where_nothing_else_speaks():
    before, after = _mean_action_after_updates_without_reward(0.01)
    assert after < 0.5 * before


def test_mean_regularisation_is_refused_where_it_would_do_nothing():
    with pytest.raises(ConfigError, match="mean_reg_coef is -1"):
        make(LiftLabPPO, mean_reg_coef=-1.0)
    with pytest.raises(ConfigError, match="mean_reg_coef needs micro-batches"):
        make(LiftLabPPO, mean_reg_coef=0.1, use_mixed_precision=True)
    with pytest.raises(ConfigError, match="mean_reg_coef needs micro-batches"):
        make(LiftLabPPO, mean_reg_coef=0.1, micro_batches=False)


def test_micro_batches_that_are_asked_for_are_refused_where_they_cannot_be():
    assert make(LiftLabPPO, use_mixed_precision=True).micro_batches is None
    with pytest.raises(ConfigError, match="micro_batches needs a Gaussian multi-layer perceptron"):
        make(LiftLabPPO, micro_batches=True, use_mixed_precision=True)


def test_time_outs_of_an_earlier_rollout_are_not_those_of_a_later_one():
    """An environment may tell of time-outs only in steps that have some."""
    ours = make(LiftLabPPO)
    obs, ones = TensorDict({"policy": torch.zeros(NUM_ENVS, OBS)}, batch_size=[NUM_ENVS]), torch.ones(NUM_ENVS)
    rewards = []
    for extras in ({"time_outs": ones.bool()}, {}):
        with torch.inference_mode():
            for _ in range(STEPS):
                ours.act(obs)
                ours.process_env_step(obs, ones, ones.long(), dict(extras))
            ours.compute_returns(obs)
        rewards.append(ours.storage.rewards.clone())
        ours.update()
    assert (rewards[0] != 1.0).all()  # the value of a state that time ended comes on top
    assert (rewards[1] == 1.0).all()
