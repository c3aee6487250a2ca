"""Settings that skrl and Stable-Baselines3 fail at are refused in one line; odd ones that work are taken."""

import pytest

from lift_lab.utils.errors import ConfigError, ConfigTypeError
from lift_lab_rl.library_ranges import (
    SB3_NEEDED,
    SB3_RANGES,
    SKRL_NEEDED,
    SKRL_RANGES,
    check_library_cfg,
    check_skrl_mini_batches,
    refusals_of,
)


def check(cfg):
    """Check a configuration: of skrl's runner, which has a trainer, or of Stable-Baselines3's PPO."""
    check_library_cfg(cfg, *((SKRL_RANGES, SKRL_NEEDED) if "trainer" in cfg else (SB3_RANGES, SB3_NEEDED)))


@pytest.mark.parametrize(
    ("cfg", "says"),
    [
        ({"n_steps": None}, "agent.n_steps is null"),
        ({"policy": None}, "agent.policy is null"),
        ({"trainer": None}, "agent.trainer is null"),
        ({"trainer": {}, "memory": None}, "agent.memory is null"),
        ({"trainer": {}, "agent": {"experiment": None}}, "agent.agent.experiment is null"),
        ({"trainer": {"timesteps": None}}, "agent.trainer.timesteps is null"),
    ],
)
def test_what_is_needed_is_not_null(cfg, says):
    with pytest.raises(ConfigError, match=says):
        check(cfg)


@pytest.mark.parametrize(
    "cfg",
    [
        {"target_kl": None, "clip_range_vf": None, "learning_rate": "lin_3e-4", "gamma": 1, "ent_coef": 0},
        {"trainer": {"timesteps": 10}, "agent": {"learning_rate_scheduler": None, "grad_norm_clip": 0}},
        {"trainer": {}, "agent": {"discount_factor": 1.0, "kl_threshold": 0, "value_clip": 0}},
    ],
)
def test_odd_settings_that_work_are_taken(cfg):
    check(cfg)


def test_a_mini_batch_of_skrl_is_not_empty():
    cfg = {"agent": {"rollouts": 16, "mini_batches": 64}}
    check_skrl_mini_batches(cfg, 4)
    with pytest.raises(ConfigError, match="mini_batches is 64: a rollout of 3 environments and 16 steps has only 48"):
        check_skrl_mini_batches(cfg, 3)


def test_what_a_library_says_is_kept():
    with (
        pytest.raises(ConfigError, match="skrl refuses a setting below agent: no Foo"),
        refusals_of("skrl"),
    ):
        raise ValueError("no Foo")
    with pytest.raises(ConfigTypeError, match=r"^ours$"), refusals_of("skrl"):
        raise ConfigTypeError("ours")
    with pytest.raises(KeyError), refusals_of("skrl"):  # a fault of ours
        raise KeyError("x")
