"""With our parts off, a training with our runner and PPO has the bits of one with rsl_rl's runner and PPO.

rsl_rl's own ``OnPolicyRunner`` and ``PPO`` train the same task from the same seed. Only the configuration that goes
into them is ours.
"""

import pytest
import torch
from point_task import AgentCfg, PointEnv
from rsl_rl.algorithms import PPO
from rsl_rl.runners import OnPolicyRunner
from tensordict import TensorDict

from lift_lab_rl.rsl_rl import (
    LiftLabPPO,
    LiftLabRunner,
    RslRlPpoActorCriticRecurrentCfg,
    RslRlRndCfg,
    RslRlSymmetryCfg,
    to_rsl_rl,
)

pytestmark = pytest.mark.usefixtures("one_torch_thread")

ITERATIONS = 3


def mirrored(env, obs=None, actions=None):
    """A point at the other side of zero; its observation is (position, position squared)."""
    if obs is not None:
        flipped = TensorDict({"policy": obs["policy"] * torch.tensor([-1.0, 1.0])}, batch_size=obs.batch_size)
        obs = torch.cat([obs, flipped])
    return obs, None if actions is None else torch.cat([actions, -actions])


def recurrent(kind):
    def change(cfg):
        settings = {k: v for k, v in vars(cfg.policy).items() if k != "class_name"}
        cfg.policy = RslRlPpoActorCriticRecurrentCfg(**settings, rnn_type=kind, rnn_hidden_dim=6, rnn_num_layers=1)

    return change


def curious(cfg):
    schedule = RslRlRndCfg.LinearWeightScheduleCfg(initial_step=0, final_step=100, final_value=0.0)
    more = {"reward_normalization": True, "state_normalization": True, "weight_schedule": schedule}
    cfg.algorithm.rnd_cfg = RslRlRndCfg(weight=10.0, num_outputs=4, **more)
    cfg.obs_groups = {"policy": ["policy"], "rnd_state": ["policy"]}


def symmetric(augment, loss):
    def change(cfg):
        settings = {"use_data_augmentation": augment, "use_mirror_loss": loss, "mirror_loss_coeff": 0.5}
        cfg.algorithm.symmetry_cfg = RslRlSymmetryCfg(data_augmentation_func=mirrored, **settings)

    return change


def algorithm(**settings):
    return lambda cfg: [setattr(cfg.algorithm, name, value) for name, value in settings.items()]


def policy(**settings):
    return lambda cfg: [setattr(cfg.policy, name, value) for name, value in settings.items()]


OPTIONS = {
    "defaults": lambda cfg: None,
    "no normalisation": policy(actor_obs_normalization=False, critic_obs_normalization=False),
    "only the critic normalises": policy(actor_obs_normalization=False),
    "scalar deviation": policy(noise_std_type="scalar"),
    "deviation by observation": policy(state_dependent_std=True),
    "tanh": policy(activation="tanh"),
    "advantages by minibatch": algorithm(normalize_advantage_per_mini_batch=True),
    "fixed rate": algorithm(schedule="fixed"),
    "plain value loss": algorithm(use_clipped_value_loss=False),
    "sgd": algorithm(optimizer="sgd"),
    "gru": recurrent("gru"),
    "lstm": recurrent("lstm"),
    "random network distillation": curious,
    "symmetry: augmentation": symmetric(True, False),
    "symmetry: mirror loss": symmetric(False, True),
}


def state(alg):
    """Every number that the next iteration depends on."""
    numbers = [torch.tensor([alg.learning_rate])]
    for network in (alg.actor, alg.critic, *([alg.rnd] if alg.rnd else [])):
        numbers += network.state_dict().values()
    for entries in alg.optimizer.state_dict()["state"].values():
        numbers += [torch.as_tensor(value) for value in entries.values() if value is not None]
    return torch.cat([value.detach().double().flatten() for value in numbers])


def trained(runner_class, name, **settings):
    """A runner after its training, and the state of torch's random numbers."""
    cfg = AgentCfg()
    OPTIONS[name](cfg)
    for key, value in settings.items():
        setattr(cfg.algorithm, key, value)
    torch.manual_seed(7)
    runner = runner_class(PointEnv(), to_rsl_rl(cfg), None, "cpu")
    runner.learn(ITERATIONS, init_at_random_ep_len=True)
    return runner, torch.get_rng_state()


@pytest.mark.parametrize("name", OPTIONS)
def test_with_our_parts_off_every_bit_is_rsl_rls(name):
    theirs, their_stream = trained(OnPolicyRunner, name, class_name="PPO")
    ours, our_stream = trained(LiftLabRunner, name, micro_batches=False)
    assert type(theirs.alg) is PPO
    assert type(ours.alg) is LiftLabPPO
    assert torch.equal(state(ours.alg), state(theirs.alg))
    assert torch.equal(our_stream, their_stream)


def test_rsl_rls_ppo_in_our_runner_has_the_bits_it_has_in_rsl_rls():
    theirs, _ = trained(OnPolicyRunner, "defaults", class_name="PPO")
    ours, _ = trained(LiftLabRunner, "defaults", class_name="PPO")
    assert type(ours.alg) is PPO
    assert torch.equal(state(ours.alg), state(theirs.alg))


def test_our_ppo_in_rsl_rls_runner_has_the_bits_it_has_in_ours():
    settings = {"gamma_final": 0.9, "anneal_iterations": (1, 2), "mean_reg_coef": 0.01, "advantage_clip": 0.5}
    theirs, _ = trained(OnPolicyRunner, "defaults", **settings)
    ours, _ = trained(LiftLabRunner, "defaults", **settings)
    assert ours.alg.gamma == theirs.alg.gamma == pytest.approx(0.9)
    assert torch.equal(state(ours.alg), state(theirs.alg))


@pytest.mark.parametrize(
    "settings",
    [
        {"entropy_coef_final": 0.5},
        {"desired_kl_final": 1e-4},
        {"gamma_final": 0.5},
        {"mean_reg_coef": 0.1},
        {"advantage_clip": 0.5},
        {"micro_batches": False},
    ],
    ids=lambda settings: next(iter(settings)),
)
def test_each_part_that_is_on_changes_a_training(settings):
    without, _ = trained(LiftLabRunner, "defaults")
    with_it, _ = trained(LiftLabRunner, "defaults", **settings)
    assert not torch.equal(state(without.alg), state(with_it.alg))
