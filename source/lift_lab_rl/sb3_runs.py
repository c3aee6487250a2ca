"""Building a Stable-Baselines3 PPO from a configuration, with its checkpoint and observation statistics.

Needs the extra ``sb3``.
"""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import numpy as np
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from lift_lab.utils.errors import ConfigError, FileError, suggest

from .sb3 import Sb3VecEnvWrapper, process_sb3_cfg

_NORMALISATION = ("normalize_input", "normalize_value", "clip_obs")
"""Entries of a configuration that are VecNormalize's (Isaac Lab's names)."""


def build(
    env: Sb3VecEnvWrapper, cfg: dict[str, Any], checkpoint: Path | None = None, training: bool = True
) -> tuple[PPO, VecEnv, int]:
    """An agent and the environment that it acts in.

    Args:
        env: the wrapped environment.
        cfg: configuration, as in ``sb3_ppo_cfg.yaml``.
        checkpoint: model whose weights are taken; statistics beside it are taken too.
        training: whether the agent is to learn: statistics are updated and rewards normalised.

    Returns:
        The agent, the environment (inside VecNormalize if the configuration asks for it), and how many samples the
        configuration trains for.

    Raises:
        FileError: observations are to be normalised, and the checkpoint's statistics are not there.
        ConfigError: the configuration lacks ``policy`` or ``n_timesteps``, or has an argument that PPO does not know.
    """
    if not training:  # whatever the number of environments, there is nothing to cut into parts
        cfg = {name: value for name, value in cfg.items() if name != "batch_size"} | {"n_minibatches": 1}
    settings = process_sb3_cfg(cfg, env.num_envs)
    _check(settings)
    policy, timesteps = settings.pop("policy"), int(settings.pop("n_timesteps"))
    norm = {name: settings.pop(name) for name in _NORMALISATION if name in settings}
    vec_env: VecEnv = env
    if norm.get("normalize_input") or norm.get("normalize_value"):
        vec_env = VecNormalize(
            env,
            training=training,
            norm_obs=norm.get("normalize_input", False),
            norm_reward=norm.get("normalize_value", False) and training,
            clip_obs=norm.get("clip_obs", 10.0),
            clip_reward=np.inf,
            gamma=settings.get("gamma", 0.99),
        )
    settings.setdefault("device", env.sim_device)
    agent = PPO(policy, vec_env, **settings)
    if checkpoint is not None:
        agent.set_parameters(str(checkpoint), device=agent.device)
        stats = statistics_path(checkpoint)
        if isinstance(vec_env, VecNormalize) and (vec_env.norm_obs or stats.is_file()):
            if not stats.is_file():
                raise FileError(
                    f"'{checkpoint}' lacks its statistics of observations, '{stats}' (if it was trained without them: "
                    "agent.normalize_input=false)"
                )
            loaded = VecNormalize.load(str(stats), env)
            vec_env.obs_rms, vec_env.ret_rms = loaded.obs_rms, loaded.ret_rms
    return agent, vec_env, timesteps


def save(agent: PPO, vec_env: VecEnv, path: Path) -> None:
    """Write a model, and beside it the statistics of observations if there are any."""
    agent.save(path)
    if isinstance(vec_env, VecNormalize):
        vec_env.save(str(statistics_path(path)))


def statistics_path(model: Path) -> Path:
    """Where a model's observation statistics are: ``model_vecnormalize_8_steps.pkl`` for ``model_8_steps.zip``."""
    return model.with_name(model.name.replace("model", "model_vecnormalize", 1)).with_suffix(".pkl")


def _check(settings: dict[str, Any]) -> None:
    for name in ("policy", "n_timesteps"):
        if name not in settings:
            raise ConfigError(f"the agent's configuration has no '{name}'")
    known = {*inspect.signature(PPO).parameters, "n_timesteps", *_NORMALISATION} - {"env"}
    for name in settings:
        if name not in known:
            raise ConfigError(f"the agent's configuration: PPO has no argument '{name}'; {suggest(name, known)}")
