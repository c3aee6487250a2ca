"""Conversion of Isaac Lab's agent configuration to rsl_rl 5's form.

Isaac Lab 2.3 describes one ``policy`` with two networks; rsl_rl 5 takes an ``actor`` and a ``critic`` model, each with
its own class, observation normalisation and (the actor) output distribution.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import torch
from rsl_rl.algorithms import PPO
from rsl_rl.utils import resolve_callable, resolve_nn_activation

from lift_lab.utils.errors import ConfigError, suggest

from .evaluation_cfg import RslRlEvaluationCfg
from .ppo import LiftLabPPO
from .rl_cfg import RslRlOnPolicyRunnerCfg, RslRlPpoActorCriticCfg, RslRlPpoActorCriticRecurrentCfg
from .time_outs import FINAL_OBS, PREVIOUS_OBS
from .wandb_writer import require_logger

_OBS_SETS = ("actor", "critic", "rnd_state")
"""What rsl_rl's on-policy runner takes groups of observations for."""

_MEMORIES = ("lstm", "gru")
"""Kinds of recurrent networks; rsl_rl takes any other name for the first."""

LIFT_LAB_PPO = "lift_lab_rl.rsl_rl.ppo:LiftLabPPO"
SYMMETRIC_MLP = "lift_lab_rl.rsl_rl.symmetric_policy:SymmetricMlp"
WANDB_WRITER = "lift_lab_rl.rsl_rl.wandb_writer:WandbWriter"


_PARTS: dict[str, tuple[Any, ...]] = {
    "algorithm.micro_batches": (None, False),
    "algorithm.entropy_coef_final": (None,),
    "algorithm.desired_kl_final": (None,),
    "algorithm.gamma_final": (None,),
    "algorithm.anneal_at_success": (None,),
    "algorithm.mean_reg_coef": (0,),
    "algorithm.advantage_clip": (None,),
    "algorithm.time_out_bootstrap": (PREVIOUS_OBS,),
    "algorithm.symmetry_cfg.average_policy": (None, False),
    "average_share": (0,),
    "policy.init_action_mean": (None,),
}
"""Setting of each part of our PPO, and the values that switch it off."""

_OURS = {path.rpartition(".")[2] for path in _PARTS} | {"anneal_iterations", "advantage_clip_start"}


def to_rsl_rl(cfg: RslRlOnPolicyRunnerCfg, obs_names: Iterable[Any] = ("policy",)) -> dict[str, Any]:
    """The dictionary that rsl_rl 5's runner takes.

    Args:
        cfg: agent configuration; not changed.
        obs_names: names of the environment's observation groups.

    Returns:
        A new nested dictionary of plain values.

    Raises:
        ConfigError: a class, an observation group or a logger that is not known.
        TypeError: a value is missing; the message lists the paths.
    """
    cfg = cfg.copy()
    cfg.validate(prefix="agent")
    if cfg.class_name != "OnPolicyRunner":
        raise ConfigError(
            f"agent.class_name: there is no runner '{cfg.class_name}'; {suggest(cfg.class_name, ['OnPolicyRunner'])}"
        )
    plain = cfg.to_dict()
    plain.pop("policy")
    plain["actor"], plain["critic"] = _networks(cfg.policy, cfg.empirical_normalization)
    plain["obs_groups"] = _obs_groups(cfg.obs_groups, list(obs_names))
    plain["algorithm"] = _algorithm(cfg)
    if plain["algorithm"]["symmetry_cfg"] and plain["algorithm"]["symmetry_cfg"].pop("average_policy"):
        plain["actor"]["class_name"] = _symmetric_class(cfg.policy)
    plain["logger"] = _logger(cfg)
    plain["multi_gpu"] = None
    _check_evaluation(cfg.evaluation)
    return plain


def _check_evaluation(cfg: RslRlEvaluationCfg | None) -> None:
    if cfg is None:
        return
    if (cfg.error_metric is None) != (cfg.max_error is None):
        raise ConfigError(
            "agent.evaluation: error_metric and max_error are the name and the limit of one error: give both or none"
        )
    if cfg.num_envs is not None and cfg.num_envs > cfg.episodes:
        raise ConfigError(
            f"agent.evaluation.num_envs is {cfg.num_envs}, more than the {cfg.episodes} episodes; "
            f"give at most {cfg.episodes}"
        )


def _networks(policy: RslRlPpoActorCriticCfg, normalise_both: bool | None) -> tuple[dict[str, Any], dict[str, Any]]:
    names = {"ActorCritic": "MLPModel", "ActorCriticRecurrent": "RNNModel"}
    if policy.class_name not in names:
        raise ConfigError(
            f"agent.policy.class_name: no networks '{policy.class_name}'; {suggest(policy.class_name, names)}"
        )
    try:
        resolve_nn_activation(policy.activation)
    except ValueError as error:
        raise ConfigError(f"agent.policy.activation: {error}") from error
    common: dict[str, Any] = {"class_name": names[policy.class_name], "activation": policy.activation}
    if isinstance(policy, RslRlPpoActorCriticRecurrentCfg):
        if str(policy.rnn_type).lower() not in _MEMORIES:
            hint = suggest(str(policy.rnn_type), _MEMORIES)
            raise ConfigError(f"agent.policy.rnn_type: no memory '{policy.rnn_type}'; {hint}")
        common |= {key: getattr(policy, key) for key in ("rnn_type", "rnn_hidden_dim", "rnn_num_layers")}
    elif common["class_name"] == "RNNModel":
        raise ConfigError("agent.policy: 'ActorCriticRecurrent' needs an RslRlPpoActorCriticRecurrentCfg")
    low, high = policy.noise_std_range
    if not 0.0 <= low < high:
        raise ConfigError(f"agent.policy.noise_std_range: expected 0 <= low < high, got ({low}, {high})")
    if policy.state_dependent_std and policy.init_action_mean is not None:
        raise ConfigError("agent.policy.init_action_mean needs state_dependent_std=False")
    kind = "Heteroscedastic" if policy.state_dependent_std else ""
    distribution = {
        "class_name": f"{kind}GaussianDistribution",
        "init_std": torch.tensor(std) if isinstance(std := policy.init_noise_std, list) else std,
        "std_type": policy.noise_std_type,
        "std_range": (low, high),
    }
    actor = common | {
        "hidden_dims": list(policy.actor_hidden_dims),
        "obs_normalization": policy.actor_obs_normalization if normalise_both is None else normalise_both,
        "distribution_cfg": distribution,
    }
    critic = common | {
        "hidden_dims": list(policy.critic_hidden_dims),
        "obs_normalization": policy.critic_obs_normalization if normalise_both is None else normalise_both,
    }
    return actor, critic


def _symmetric_class(policy: RslRlPpoActorCriticCfg) -> str:
    if policy.class_name != "ActorCritic" or policy.state_dependent_std:
        raise ConfigError(
            "agent.algorithm.symmetry_cfg.average_policy needs agent.policy.class_name=ActorCritic and "
            "state_dependent_std=False"
        )
    return SYMMETRIC_MLP


def _obs_groups(groups: dict[str, list[str]], names: list[str]) -> dict[str, list[str]]:
    resolved = {("actor" if key == "policy" else key): list(value) for key, value in groups.items()}
    resolved.setdefault("actor", ["policy"])
    resolved.setdefault("critic", ["critic"] if "critic" in names else list(resolved["actor"]))
    for key, value in resolved.items():
        if key not in _OBS_SETS:
            raise ConfigError(f"agent.obs_groups: no network takes '{key}'; {suggest(key, ['policy', *_OBS_SETS])}")
        if not value:
            raise ConfigError(f"agent.obs_groups.{key} is empty; {suggest('', names)}")
        for name in value:
            if name not in names:
                raise ConfigError(
                    f"agent.obs_groups.{key}: the environment has no observation group '{name}'; {suggest(name, names)}"
                )
    return resolved


def _algorithm(cfg: RslRlOnPolicyRunnerCfg) -> dict[str, Any]:
    """The algorithm's class and arguments. Only our PPO gets those that are ours."""
    algorithm = cfg.algorithm.to_dict()
    for name, kinds in (("schedule", ("adaptive", "fixed")), ("time_out_bootstrap", (PREVIOUS_OBS, FINAL_OBS))):
        if algorithm[name] not in kinds:
            raise ConfigError(
                f"agent.algorithm.{name}: no {name} '{algorithm[name]}'; {suggest(algorithm[name], kinds)}"
            )
    if algorithm["advantage_clip"] is not None and algorithm["normalize_advantage_per_mini_batch"]:
        raise ConfigError("agent.algorithm.advantage_clip needs normalize_advantage_per_mini_batch=False")
    if algorithm["anneal_at_success"] is not None:
        waiting = ("entropy_coef_final", "desired_kl_final", "gamma_final", "advantage_clip")
        if all(algorithm[setting] is None for setting in waiting):
            raise ConfigError(
                f"agent.algorithm.anneal_at_success has no effect without a schedule; set one of {', '.join(waiting)}, "
                f"or anneal_at_success=null"
            )
    name = algorithm["class_name"]
    algorithm["class_name"] = LIFT_LAB_PPO if name == "LiftLabPPO" else name
    more = {
        "num_threads": cfg.num_threads,
        "average_share": cfg.average_share,
        "init_action_mean": cfg.policy.init_action_mean,
    }
    if issubclass(_algorithm_class(algorithm["class_name"], name), LiftLabPPO):
        return algorithm | more
    used = {path: off[0] for path, off in _PARTS.items() if _value_at(cfg, path) not in off}
    if used:
        overrides = (f"agent.{path}={'null' if off is None else off}" for path, off in used.items())
        raise ConfigError(
            f"agent.algorithm.class_name: '{name}' has none of the parts of LiftLabPPO; "
            f"switch off those that are on: {' '.join(overrides)}"
        )
    return {key: value for key, value in algorithm.items() if key not in _OURS}


def _value_at(cfg: RslRlOnPolicyRunnerCfg, path: str) -> Any:
    value: Any = cfg
    for name in path.split("."):
        value = None if value is None else getattr(value, name)
    return value


def _algorithm_class(path: str, name: str) -> type[PPO]:
    """The class at ``path``, which the user calls ``name``."""
    known = "use LiftLabPPO, rsl_rl's PPO, or 'module:Class' of a sub-class of either"
    try:
        found = resolve_callable(path)
    except (ValueError, ImportError, AttributeError) as error:
        raise ConfigError(f"agent.algorithm.class_name: no algorithm '{name}'; {known}") from error
    if not (isinstance(found, type) and issubclass(found, PPO)):
        raise ConfigError(f"agent.algorithm.class_name: '{name}' is no PPO; {known}")
    return found


def _logger(cfg: RslRlOnPolicyRunnerCfg) -> str | dict[str, Any]:
    if cfg.logger == "tensorboard":
        return "tensorboard"
    if cfg.logger == "wandb":
        return {"class_name": WANDB_WRITER, "project_name": cfg.wandb_project}
    require_logger(cfg.logger)
    raise ConfigError(f"agent.logger: no logger '{cfg.logger}'; {suggest(cfg.logger, ['tensorboard', 'wandb'])}")
