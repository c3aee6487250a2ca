"""Checks before a training that an agent's configuration fits the environment."""

from __future__ import annotations

import itertools
from typing import Any

import torch
from rsl_rl.utils import resolve_callable

from lift_lab.envs.mirror import check_mirror
from lift_lab.sim.physics.memory import check_fits
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab_rl.counters import manager_env
from lift_lab_rl.random_state import load_rng_state, rng_state

from .best_policy import BestPolicy
from .symmetry import mirror_samples
from .time_outs import FINAL_OBS, check_final_obs


def check_environment(env: Any, cfg: dict[str, Any], device: str, saves: bool) -> None:
    """Find settings that do not fit the environment.

    Args:
        env: environment, as rsl_rl sees it.
        cfg: what :func:`~lift_lab_rl.rsl_rl.cfg_conversion.to_rsl_rl` returns.
        device: device of the learner.
        saves: whether checkpoints are written.

    Raises:
        ConfigError: noise or mean has another number of actions, the environment does not support the bootstrap, a
            rollout does not fit into memory, the success metric is not logged, or the declared symmetry is wrong.
    """
    _check_actions(env, cfg)
    if cfg["algorithm"].get("time_out_bootstrap") == FINAL_OBS:
        check_final_obs(env)
    obs = env.get_observations()
    _check_networks(cfg, obs, device)
    numbers = sum(value[0].numel() for value in obs.values()) + 3 * env.num_actions + 6
    check_fits("agent.num_steps_per_env", cfg["num_steps_per_env"], 4 * numbers * env.num_envs, device)
    metric, inner = cfg.get("success_metric"), manager_env(env)
    known = [] if inner is None else list(inner.extras.get("log", {}))
    if saves and metric is not None and known and metric not in known:
        raise ConfigError(f"agent.success_metric is '{metric}', which is not logged; {suggest(metric, known)}")
    if saves and cfg["algorithm"].get("anneal_at_success") is not None:
        check_success_is_logged(env, cfg, "agent.algorithm.anneal_at_success")
    evaluation = cfg.get("evaluation")
    if saves and evaluation is not None:
        if evaluation["from_success"] is not None:
            check_success_is_logged(env, cfg, "agent.evaluation.from_success")
        error, known = evaluation["error_metric"], [] if inner is None else inner.metrics_manager.log_names
        if error is not None and error not in known:
            raise ConfigError(f"agent.evaluation.error_metric: there is no metric '{error}'; {suggest(error, known)}")
    _check_symmetry(inner, cfg)


def check_success_is_logged(env: Any, cfg: dict[str, Any], setting: str) -> None:
    """Check that a manager-based environment logs a success rate.

    Args:
        env: environment, as rsl_rl sees it.
        cfg: what :func:`~lift_lab_rl.rsl_rl.cfg_conversion.to_rsl_rl` returns.
        setting: path of the setting that needs it.

    Raises:
        ConfigError: it logs none.
    """
    inner = manager_env(env)
    if inner is None or cfg.get("success_metric") is not None:
        return
    logged = dict.fromkeys([*inner.extras.get("log", {}), *inner.metrics_manager.log_names], 1.0)
    if BestPolicy().success(logged) is None:
        raise ConfigError(
            f"{setting} needs a success rate, and this task logs none: give it a metrics term or a termination term "
            f"'success', or name a log in agent.success_metric"
        )


def _check_symmetry(env: Any, cfg: dict[str, Any]) -> None:
    """A declared symmetry that is used has to be that of the environment."""
    symmetry = cfg["algorithm"].get("symmetry_cfg")
    if symmetry is None:
        return
    try:
        function = resolve_callable(symmetry["data_augmentation_func"])
    except (ValueError, ImportError, AttributeError) as error:
        raise ConfigError(
            "agent.algorithm.symmetry_cfg.data_augmentation_func: no function "
            f"'{symmetry['data_augmentation_func']}'; give 'module:name' of one"
        ) from error
    if function is not mirror_samples:
        return
    if env is None:
        raise ConfigError(
            "agent.algorithm.symmetry_cfg.data_augmentation_func: the default mirrors manager-based environments; "
            "give a function for yours"
        )
    random_numbers = rng_state()
    check_mirror(env, dict.fromkeys(group for groups in cfg["obs_groups"].values() for group in groups))
    load_rng_state(random_numbers)


def _check_actions(env: Any, cfg: dict[str, Any]) -> None:
    """What is given for each action has to be given for each of this environment's actions."""
    noise = cfg["actor"].get("distribution_cfg", {}).get("init_std")
    for name, given in (("init_noise_std", noise), ("init_action_mean", cfg["algorithm"].get("init_action_mean"))):
        if isinstance(given, (torch.Tensor, list)) and torch.as_tensor(given).shape != (env.num_actions,):
            raise ConfigError(
                f"agent.policy.{name}: {len(given)} values for {env.num_actions} actions; give one for each"
                + (", or a single one" if name == "init_noise_std" else "")
            )


def _check_networks(cfg: dict[str, Any], obs: Any, device: str) -> None:
    """Networks see vectors, and their weights, gradients and optimiser state have to fit into memory."""
    for name in ("actor", "critic"):
        if cfg[name]["class_name"] not in ("MLPModel", "RNNModel"):
            continue
        groups = cfg["obs_groups"][name]
        for group in groups:
            if not isinstance(obs[group], torch.Tensor) or obs[group].ndim != 2:
                raise ConfigError(
                    f"agent.obs_groups: the {name} sees vectors, but group '{group}' is none; set "
                    f"env.observations.{group}.concatenate_terms=true and leave out terms of other shapes"
                )
        widths = [sum(obs[group].shape[1] for group in groups), *cfg[name]["hidden_dims"]]
        weights = sum(before * after for before, after in itertools.pairwise(widths))
        check_fits(f"the number of weights of agent.policy.{name}_hidden_dims", weights, 4 * 4, device)
