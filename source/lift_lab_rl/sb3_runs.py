"""Building a Stable-Baselines3 PPO from a configuration, with its checkpoint and observation statistics.

Needs the extra ``sb3``.
"""

from __future__ import annotations

import copy
import inspect
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import HumanOutputFormat, KVWriter, TensorBoardOutputFormat, configure
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from lift_lab.utils.errors import ConfigError, FileError, suggest

from .curve_layout import layout
from .files import save_torch
from .library_files import read_sb3, read_states, refusal
from .library_ranges import refusals_of
from .sb3 import Sb3VecEnvWrapper, process_sb3_cfg
from .scalar_names import SB3_NAMES, SUCCESS_RATE

_NORMALISATION = ("normalize_input", "normalize_value", "clip_obs")
"""Entries of a configuration that are VecNormalize's (Isaac Lab's names)."""


def build(
    env: Sb3VecEnvWrapper,
    cfg: dict[str, Any],
    checkpoint: Path | None = None,
    training: bool = True,
    trust: bool = False,
) -> tuple[PPO, VecEnv, int]:
    """An agent and the environment that it acts in.

    Args:
        env: the wrapped environment.
        cfg: configuration, as in ``sb3_ppo_cfg.yaml``.
        checkpoint: model whose weights are taken; statistics beside it are taken too.
        training: whether the agent is to learn: statistics are updated and rewards normalised.
        trust: whether to read a checkpoint's files that hold more than tensors and plain values, as older versions
            wrote statistics. This runs code that is in them.

    Returns:
        The agent, the environment (inside VecNormalize if the configuration asks for it), and the configuration's
        number of samples.

    Raises:
        FileError: a file of the checkpoint is damaged or not trusted, or the statistics for normalised observations are
            missing.
        ConfigError: the configuration lacks ``policy`` or ``n_timesteps``, or has an argument that PPO does not have.
            Also a checkpoint of another library or another agent.
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
    with refusals_of("Stable-Baselines3"):
        agent = PPO(policy, vec_env, **settings)
    if checkpoint is not None:
        load_parameters(agent, checkpoint, trust)
        if isinstance(vec_env, VecNormalize):
            _load_statistics_of(checkpoint, vec_env, env, trust)
    return agent, vec_env, timesteps


def load_parameters(agent: PPO, path: str | Path, trust: bool = False) -> None:
    """Load networks and optimiser of a model, and nothing else; see :func:`~lift_lab_rl.library_files.read_sb3`.

    Args:
        agent: the agent that they are loaded into.
        path: model that ``agent.save`` wrote.
        trust: whether to read entries that hold more than tensors and plain values, which runs code that is in them.

    Raises:
        FileError: there is no such file, it is damaged, or it is not trusted.
        ConfigError: the file is of another library or of another agent. The agent is as it was.
    """
    states: Any = read_sb3(path, trust, agent.device)
    before: Any = copy.deepcopy(agent.get_parameters())
    try:
        agent.set_parameters(states, exact_match=True, device=agent.device)
    except Exception as error:  # whatever a wrong state makes of it
        agent.set_parameters(before, exact_match=True, device=agent.device)
        reason = " ".join(str(error).split())[:200].rstrip(" .")
        raise ConfigError(f"checkpoint '{path}' does not fit this agent: {reason}") from error


# -- statistics of observations and returns


def _load_statistics_of(checkpoint: Path, vec_env: VecNormalize, env: VecEnv, trust: bool) -> None:
    path = statistics_path(checkpoint)
    older = path.with_suffix(".pkl")
    if path.is_file():
        load_statistics(vec_env, path)
    elif older.is_file():
        if not trust:
            raise FileError(refusal(str(older)))
        loaded = VecNormalize.load(str(older), env)
        vec_env.obs_rms, vec_env.ret_rms = loaded.obs_rms, loaded.ret_rms
    elif vec_env.norm_obs:
        raise FileError(
            f"'{checkpoint}' lacks its statistics of observations, '{path}' (if it was trained without them: "
            "agent.normalize_input=false)"
        )


def save(agent: PPO, vec_env: VecEnv | None, path: Path) -> None:
    """Write a model, and beside it the statistics of observations if there are any."""
    agent.save(path)
    if isinstance(vec_env, VecNormalize):
        save_statistics(vec_env, statistics_path(path))


def save_statistics(vec_env: VecNormalize, path: str | Path) -> None:
    """Write the running means and variances of observations and returns, as tensors.

    Stable-Baselines3's own file is a pickle, which runs code when it is read.

    Args:
        vec_env: the environment that keeps them.
        path: where to.
    """
    obs: Any = getattr(vec_env, "obs_rms", None) if vec_env.norm_obs else None
    groups = obs if isinstance(obs, dict) else {} if obs is None else {"": obs}
    content = {"observations": {name: _numbers(rms) for name, rms in groups.items()}}
    save_torch(path, {**content, "returns": _numbers(vec_env.ret_rms)})


def load_statistics(vec_env: VecNormalize, path: str | Path) -> None:
    """Read a file of :func:`save_statistics`.

    Args:
        vec_env: the environment that takes them.
        path: the file.

    Raises:
        FileError: there is no such file, or it is damaged.
        ConfigError: it holds something else, or statistics of other observations.
    """
    content = read_states(path)
    try:
        found = {name: _statistics(numbers) for name, numbers in content["observations"].items()}
        returns = _statistics(content["returns"])
    except (KeyError, TypeError, AttributeError, ValueError, RuntimeError) as error:
        raise ConfigError(f"'{path}' holds no statistics of observations") from error
    if vec_env.norm_obs:
        own: Any = vec_env.obs_rms
        wanted = own if isinstance(own, dict) else {"": own}
        shapes = [{name: rms.mean.shape for name, rms in group.items()} for group in (wanted, found)]
        if shapes[0] != shapes[1]:
            raise ConfigError(f"'{path}' is of other observations: expected shapes {shapes[0]}, got {shapes[1]}")
        vec_env.obs_rms = found if isinstance(own, dict) else found[""]
    vec_env.ret_rms = returns


def _numbers(rms: RunningMeanStd) -> dict[str, Any]:
    return {"mean": torch.as_tensor(rms.mean), "var": torch.as_tensor(rms.var), "count": float(rms.count)}


def _statistics(numbers: dict[str, Any]) -> RunningMeanStd:
    rms = RunningMeanStd(shape=tuple(numbers["mean"].shape))
    rms.mean, rms.var, rms.count = numbers["mean"].numpy(), numbers["var"].numpy(), numbers["count"]
    return rms


def statistics_path(model: Path) -> Path:
    """Return the file of a model's observation statistics: ``model_vecnormalize_8_steps.pt`` for
    ``model_8_steps.zip``."""
    return model.with_name(model.name.replace("model", "model_vecnormalize", 1)).with_suffix(".pt")


def log_to(agent: PPO, folder: Path) -> None:
    """Let an agent write its log to standard output and to TensorBoard's files in a folder, under our names."""
    logger = configure(str(folder), ["stdout", "tensorboard"])
    outputs = [output for output in logger.output_formats if isinstance(output, KVWriter)]
    for output in outputs:
        if isinstance(output, TensorBoardOutputFormat):
            output.writer.add_custom_scalars(layout())
    renamed: list[KVWriter] = [_Renamed(output) for output in outputs]
    logger.output_formats = renamed
    agent.set_logger(logger)


class _Renamed(KVWriter):
    """Hands numbers on under the names that all libraries share; on a console, success is the first line."""

    def __init__(self, output: KVWriter):
        self._output, self._on_console = output, isinstance(output, HumanOutputFormat)

    def write(self, key_values: dict[str, Any], key_excluded: dict[str, tuple[str, ...]], step: int = 0) -> None:
        values, excluded = {}, {}
        for key, value in key_values.items():
            name, factor = SB3_NAMES.get(key, (key, 1.0))
            if self._on_console and name == SUCCESS_RATE:
                name = " success_rate"  # the table is sorted, and a space is before every letter
            values[name] = value if factor == 1.0 else factor * value
            excluded[name] = key_excluded[key]
        self._output.write(values, excluded, step)

    def close(self) -> None:
        self._output.close()


class SaveCallback(BaseCallback):
    """Saves model and statistics at regular intervals: ``model_N_steps.zip`` after N samples."""

    def __init__(self, save_freq: int, folder: str | Path):
        """As Stable-Baselines3's ``CheckpointCallback``, but its file of statistics holds no pickle.

        Args:
            save_freq: environment steps between two models.
            folder: where to.
        """
        super().__init__()
        self._save_freq, self._folder = save_freq, Path(folder)

    def _on_step(self) -> bool:
        if self.n_calls % self._save_freq == 0:
            path = self._folder / f"model_{self.num_timesteps}_steps.zip"
            save(self.model, self.model.get_vec_normalize_env(), path)  # type: ignore[arg-type]
        return True


def _check(settings: dict[str, Any]) -> None:
    for name in ("policy", "n_timesteps"):
        if name not in settings:
            raise ConfigError(f"the agent's configuration has no '{name}'")
    known = {*inspect.signature(PPO).parameters, "n_timesteps", *_NORMALISATION} - {"env"}
    for name in settings:
        if name not in known:
            raise ConfigError(f"the agent's configuration: PPO has no argument '{name}'; {suggest(name, known)}")
