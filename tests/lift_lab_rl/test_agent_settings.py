"""Configuration arrives at rsl_rl as it was meant, and settings that could not work are refused."""

import math

import pytest
import torch
from point_task import AgentCfg, PointEnv, train, with_algorithm
from rsl_rl.algorithms import PPO

from lift_lab.utils.errors import ConfigError
from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlPpoActorCriticCfg, RslRlPpoActorCriticRecurrentCfg, to_rsl_rl
from lift_lab_rl.rsl_rl.gaussian import action_std
from lift_lab_rl.rsl_rl.ppo import LiftLabPPO

# -- configuration


def test_policy_becomes_an_actor_and_a_critic_model():
    plain = to_rsl_rl(AgentCfg())
    assert plain["actor"]["class_name"] == plain["critic"]["class_name"] == "MLPModel"
    assert plain["actor"]["hidden_dims"] == [16, 8]
    assert plain["actor"]["obs_normalization"] is True
    assert plain["actor"]["distribution_cfg"]["std_type"] == "log"
    assert plain["actor"]["distribution_cfg"]["std_range"] == pytest.approx((math.exp(-20), math.exp(2)))
    assert "distribution_cfg" not in plain["critic"]
    assert plain["obs_groups"] == {"actor": ["policy"], "critic": ["policy"]}
    assert "policy" not in plain


def test_a_critic_group_is_used_where_the_environment_has_one():
    assert to_rsl_rl(AgentCfg(), ["policy", "critic"])["obs_groups"]["critic"] == ["critic"]


def test_isaac_labs_older_normalisation_switch_sets_both():
    plain = to_rsl_rl(AgentCfg(empirical_normalization=False))
    assert not plain["actor"]["obs_normalization"]
    assert not plain["critic"]["obs_normalization"]


def test_recurrent_networks_carry_their_layers():
    cfg = AgentCfg()
    settings = {k: v for k, v in vars(cfg.policy).items() if k != "class_name"}
    cfg.policy = RslRlPpoActorCriticRecurrentCfg(**settings, rnn_type="gru", rnn_hidden_dim=6, rnn_num_layers=1)
    plain = to_rsl_rl(cfg)
    cfg.policy.rnn_type = "grru"
    with pytest.raises(ConfigError, match=r"agent\.policy\.rnn_type: no memory 'grru'; did you mean 'gru'"):
        to_rsl_rl(cfg)
    assert plain["actor"]["class_name"] == "RNNModel"
    assert plain["critic"]["rnn_hidden_dim"] == 6
    runner = LiftLabRunner(PointEnv(), plain)
    assert runner.learn(1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"class_name": "OnPolicyRuner"}, "did you mean 'OnPolicyRunner'"),
        ({"obs_groups": {"policy": ["polcy"]}}, "no observation group 'polcy'; did you mean 'policy'"),
        ({"obs_groups": {"polcy": ["policy"]}}, "no network takes 'polcy'; did you mean 'policy'"),
        ({"algorithm.schedule": "adaptve"}, "no schedule 'adaptve'; did you mean 'adaptive'"),
        ({"algorithm.num_mini_batches": 0}, "agent.algorithm.num_mini_batches is 0; it must be at least 1"),
        ({"policy.activation": "eluu"}, "agent.policy.activation: Invalid activation function 'eluu'"),
        ({"save_interval": 0}, "agent.save_interval is 0; it must be at least 1"),
    ],
)
def test_wrong_names_in_the_agent_are_answered_with_the_nearest(change, message):
    cfg = AgentCfg()
    for path, value in change.items():
        *owner, name = path.split(".")
        setattr(getattr(cfg, owner[0]) if owner else cfg, name, value)
    with pytest.raises(ConfigError, match=message):
        to_rsl_rl(cfg)


@pytest.mark.parametrize(("per_batch", "enough"), [(False, 256), (True, 128)])
def test_more_minibatches_than_samples_are_refused(per_batch, enough):
    """32 environments of 8 steps; a deviation needs two samples."""
    cfg = AgentCfg()
    cfg.algorithm.normalize_advantage_per_mini_batch = per_batch
    cfg.algorithm.num_mini_batches = enough + 1
    with pytest.raises(ConfigError, match=f"has 256 samples, enough for {enough}"):
        LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    cfg.algorithm.num_mini_batches = enough
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    runner.learn(1)
    assert all(torch.isfinite(p).all() for p in runner.alg.actor.parameters())


def test_a_fixed_learning_rate_is_the_configurations_also_after_loading(tmp_path):
    cfg = AgentCfg()
    cfg.algorithm.schedule = "fixed"
    train(tmp_path, cfg=cfg)
    cfg.algorithm.learning_rate = 1e-5
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    runner.load(str(tmp_path / "model_4.pt"))
    assert runner.alg.learning_rate == runner.alg.optimizer.param_groups[0]["lr"] == 1e-5


def test_missing_agent_settings_are_listed_by_path():
    cfg = AgentCfg()
    cfg.policy = RslRlPpoActorCriticCfg()
    with pytest.raises(TypeError, match=r"agent\.policy\.init_noise_std"):
        to_rsl_rl(cfg)


def test_every_action_may_have_a_deviation_of_its_own_to_start_with(tmp_path):
    cfg = AgentCfg()
    cfg.policy.init_noise_std = [2.5]
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    assert runner.alg.get_policy().distribution.log_std_param.tolist() == pytest.approx([math.log(2.5)])
    cfg.policy.init_noise_std = [1.0, 3.0]
    with pytest.raises(ConfigError, match="2 values for 1 actions"):
        LiftLabRunner(PointEnv(), to_rsl_rl(cfg))


def test_a_new_actor_begins_about_the_mean_that_is_configured_and_a_loaded_one_where_it_was(tmp_path):
    train(tmp_path, iterations=2)
    cfg = AgentCfg()
    means = {}
    for mean in (None, [5.0]):
        cfg.policy.init_action_mean = mean
        torch.manual_seed(3)
        runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
        act = runner.get_inference_policy()
        means[str(mean)] = act(runner.env.get_observations())
        runner.load(str(tmp_path / "model_2.pt"))
        means[f"{mean}, loaded"] = act(runner.env.get_observations())
    shift = means["[5.0]"] - means["None"]  # the last layer's own random bias is replaced
    assert torch.allclose(shift, shift[:1])
    assert (means["[5.0]"] - 5.0).abs().max() < 1.0
    assert torch.equal(means["None, loaded"], means["[5.0], loaded"])
    cfg.policy.init_action_mean = [5.0, 6.0]
    with pytest.raises(ConfigError, match="init_action_mean: 2 values for 1 actions"):
        LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    cfg.policy.init_action_mean, cfg.policy.state_dependent_std = [5.0], True
    with pytest.raises(ConfigError, match="state_dependent_std=False"):
        to_rsl_rl(cfg)


def test_the_standard_deviation_stays_within_its_bounds():
    cfg = AgentCfg()
    cfg.policy.init_noise_std = 100.0
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    assert [action_std(runner.alg.get_policy())] == pytest.approx([math.exp(2.0)])


# -- the algorithm's class

OFF = "agent.algorithm.entropy_coef_final=null agent.algorithm.mean_reg_coef=0 agent.average_share=0"


def test_another_class_than_ours_is_refused_with_the_overrides_that_switch_our_parts_off():
    cfg = AgentCfg(average_share=0.1)
    cfg.algorithm.class_name, cfg.algorithm.entropy_coef_final, cfg.algorithm.mean_reg_coef = "PPO", 0.0, 0.1
    with pytest.raises(ConfigError, match=f"switch off those that are on: {OFF}$"):
        to_rsl_rl(cfg)


@pytest.mark.parametrize("name", ["PPO", "rsl_rl.algorithms:PPO", "rsl_rl.algorithms.PPO"])
def test_rsl_rls_own_ppo_gets_no_argument_of_ours(name):
    cfg = AgentCfg()
    cfg.algorithm.class_name = name
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    assert type(runner.alg) is PPO
    assert runner.learn(1)


class OwnPPO(LiftLabPPO):
    """A user's algorithm."""


def test_a_sub_class_of_ours_has_its_parts():
    cfg = AgentCfg(average_share=0.1)
    cfg.algorithm.class_name = f"{__name__}:OwnPPO"
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    assert type(runner.alg) is OwnPPO
    assert runner.alg.ema is not None


@pytest.mark.parametrize("name", ["PPOO", "no.such:PPO", "os:getcwd", "rsl_rl.algorithms:Distillation"])
def test_a_class_that_is_no_ppo_is_answered_with_what_there_is(name):
    cfg = AgentCfg()
    cfg.algorithm.class_name = name
    with pytest.raises(ConfigError, match=f"agent.algorithm.class_name.*'{name}'.*use LiftLabPPO, rsl_rl's PPO"):
        to_rsl_rl(cfg)


# -- schedules


def test_entropy_bonus_divergence_and_discount_factor_follow_their_schedules():
    cfg = AgentCfg()
    cfg.algorithm.gamma, cfg.algorithm.gamma_final = 0.9, 0.98
    cfg.algorithm.entropy_coef_final = 0.0
    cfg.algorithm.desired_kl_final = 0.004
    cfg.algorithm.anneal_iterations = (1, 3)
    used = []
    torch.manual_seed(5)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    names = ("entropy_coef", "desired_kl", "gamma")
    runner.learn(5, on_iteration=lambda _: used.append([getattr(runner.alg, name) for name in names]))
    # before iterations 0 to 4: the span begins at 1, is half over at 2, and is over at 3
    entropies, divergences, discounts = zip(*used, strict=True)
    assert entropies == pytest.approx([0.006, 0.006, 0.003, 0.0, 0.0])
    assert divergences == pytest.approx([0.01, 0.01, 0.007, 0.004, 0.004])
    assert discounts == pytest.approx([0.9, 0.9, 0.94, 0.98, 0.98])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"advantage_clip_start": -1}, "advantage_clip_start is -1"),
        ({"advantage_clip": 1.0, "normalize_advantage_per_mini_batch": True}, "normalize_advantage_per_mini_batch"),
        ({"advantage_clip": 1.0, "class_name": "PPO"}, "'PPO' has none of the parts.*advantage_clip=null"),
    ],
)
def test_advantage_clipping_that_could_not_work_is_refused(settings, message):
    cfg = with_algorithm(AgentCfg(), **settings)
    with pytest.raises(ConfigError, match=message):
        to_rsl_rl(cfg)


def test_without_final_values_there_is_no_schedule():
    assert LiftLabRunner(PointEnv(), to_rsl_rl(AgentCfg())).alg.schedules == {}


def test_a_schedule_continues_where_a_checkpoint_was(tmp_path):
    cfg = AgentCfg()
    cfg.algorithm.gamma, cfg.algorithm.gamma_final, cfg.algorithm.anneal_iterations = 0.9, 0.98, (0, 8)
    train(tmp_path, cfg=cfg)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    runner.load(str(tmp_path / "model_4.pt"))
    runner.learn(1)
    assert runner.alg.gamma == pytest.approx(0.94)


def test_a_schedule_of_no_length_is_a_jump():
    cfg = AgentCfg()
    cfg.algorithm.entropy_coef_final = 0.0
    cfg.algorithm.anneal_iterations = (2, 2)
    used = []
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(cfg))
    runner.learn(4, on_iteration=lambda _: used.append(runner.alg.entropy_coef))
    assert used == [0.006, 0.006, 0.0, 0.0]


def test_a_schedule_that_ends_before_it_begins_is_refused():
    cfg = AgentCfg()
    cfg.algorithm.anneal_iterations = (5, 3)
    with pytest.raises(ConfigError, match=r"agent.algorithm.anneal_iterations is \(5, 3\)"):
        to_rsl_rl(cfg)


def waiting_for_success(level):
    """An agent whose discount goes from 0.9 to 0.98 over the two iterations after a success rate is reached."""
    cfg = AgentCfg()
    cfg.algorithm.gamma, cfg.algorithm.gamma_final, cfg.algorithm.anneal_iterations = 0.9, 0.98, (0, 2)
    cfg.algorithm.anneal_at_success = level
    cfg.save_interval = 1
    return cfg


def test_schedules_begin_at_a_success_rate_also_after_a_resume(tmp_path):
    def discounts(runner, iterations):
        found = []
        runner.learn(iterations, on_iteration=lambda _: found.append((runner.best.smoothed_success, runner.alg.gamma)))
        return zip(*found, strict=True)

    torch.manual_seed(5)
    rates, gammas = discounts(LiftLabRunner(PointEnv(), to_rsl_rl(waiting_for_success(1.0))), 9)
    assert set(gammas) == {0.9}  # never reached
    level = max(rate for rate in rates[2:6] if rate is not None) - 1e-6
    begun = next(k for k, rate in enumerate(rates) if rate is not None and rate >= level)
    assert begun < 6

    torch.manual_seed(5)
    runner = LiftLabRunner(PointEnv(), to_rsl_rl(waiting_for_success(level)), tmp_path)
    again, gammas = discounts(runner, 9)
    assert again == rates
    assert gammas == pytest.approx([0.9] * (begun + 2) + [0.94] + [0.98] * (6 - begun))

    resumed = LiftLabRunner(PointEnv(), to_rsl_rl(waiting_for_success(level)))
    resumed.load(str(tmp_path / f"model_{begun + 1}.pt"))
    assert list(discounts(resumed, 2))[1] == pytest.approx([0.9, 0.94])


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"gamma_final": 0.98, "anneal_at_success": 1.5}, "anneal_at_success is 1.5; it must be at least 0"),
        ({"anneal_at_success": 0.9}, "anneal_at_success has no effect without a schedule"),
        ({"gamma_final": 0.98, "anneal_at_success": 0.9, "class_name": "PPO"}, "anneal_at_success=null"),
    ],
)
def test_a_success_rate_that_could_begin_nothing_is_refused(settings, message):
    cfg = with_algorithm(AgentCfg(), **settings)
    with pytest.raises(ConfigError, match=message):
        to_rsl_rl(cfg)
