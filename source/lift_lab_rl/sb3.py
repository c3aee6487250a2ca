"""Stable-Baselines3: environment wrapper, configuration, and a callback that passes the environment's log on.

Needs the extra ``sb3``.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
import torch
from torch import nn

from lift_lab.utils.errors import ConfigError, suggest

from .episode_logs import EpisodeLogs
from .nonfinite import check_step
from .optional_packages import missing_package

try:
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.vec_env import VecEnv
except ModuleNotFoundError as error:
    raise missing_package("stable_baselines3", "sb3") from error

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv

ACTION_BOUND = 100.0
"""Bound of actions where a task has none: Stable-Baselines3 works on bounded actions only (Isaac Lab's number)."""

_SCHEDULES = ("learning_rate", "clip_range", "clip_range_vf")


def process_sb3_cfg(cfg: dict[str, Any], num_envs: int) -> dict[str, Any]:
    """Turn a configuration of plain YAML values into arguments of a Stable-Baselines3 algorithm.

    ``"nn.ELU"`` becomes the class. A learning rate or clip range written ``"lin_3e-4"`` falls linearly to zero over
    the training. ``n_minibatches`` becomes the ``batch_size`` that cuts a rollout into so many.

    Args:
        cfg: the configuration; it is not changed.
        num_envs: number of environments.

    Raises:
        ConfigError: a value that cannot be read; names its key.
    """
    found = copy.deepcopy(cfg)
    _resolve_modules(found, "")
    for name in _SCHEDULES:
        if isinstance(found.get(name), str):
            found[name] = _linear(name, found[name])
    if "n_minibatches" in found:
        parts = found.pop("n_minibatches")
        samples = found.get("n_steps", 2048) * num_envs
        if parts < 1 or samples % parts:
            raise ConfigError(f"n_minibatches: a rollout of {samples} samples cannot be cut into {parts} equal parts")
        found["batch_size"] = samples // parts
    return found


def _resolve_modules(cfg: dict[str, Any], path: str) -> None:
    for key, value in cfg.items():
        if isinstance(value, dict):
            _resolve_modules(value, f"{path}{key}.")
        elif isinstance(value, str) and value.startswith("nn."):
            name = value.removeprefix("nn.")
            if not hasattr(nn, name):
                raise ConfigError(f"{path}{key}: torch.nn has no '{name}'; {suggest(name, vars(nn))}")
            cfg[key] = getattr(nn, name)


def _linear(name: str, text: str) -> Any:
    kind, _, number = text.partition("_")
    try:
        initial = float(number)
    except ValueError:
        initial = None
    if kind != "lin" or initial is None:
        raise ConfigError(f"{name}: expected a number or 'lin_<number>', got '{text}'")
    return lambda progress_remaining: progress_remaining * initial


class Sb3VecEnvWrapper(VecEnv):
    """Wraps a :class:`~lift_lab.envs.ManagerBasedRLEnv` for Stable-Baselines3 (Isaac Lab's ``Sb3VecEnvWrapper``).

    Observations are the group ``policy``, as numpy arrays; a group that keeps its terms apart is a dict, for
    ``MultiInputPolicy``. Unlike in Isaac Lab's wrapper, ``terminal_observation`` is the last observation of the episode
    that ended, and a finite horizon is not bootstrapped.
    """

    def __init__(self, env: gym.Env, fast_variant: bool = True):
        """Wrap ``env``.

        Args:
            env: environment, possibly inside gymnasium wrappers.
            fast_variant: whether ``infos`` hold only what Stable-Baselines3 reads, for environments whose episode
                ended; otherwise those also hold the environment's log.

        Raises:
            ConfigError: the environment is not manager-based, or it has no observation group ``policy``.
        """
        from lift_lab.envs import ManagerBasedRLEnv

        if not isinstance(env.unwrapped, ManagerBasedRLEnv):
            raise ConfigError(f"expected a ManagerBasedRLEnv, got {type(env.unwrapped).__name__}")
        self.env = env
        self.fast_variant = fast_variant
        inner = self._inner
        groups = inner.single_observation_space
        if "policy" not in groups.spaces:
            raise ConfigError(f"there is no observation group 'policy'; {suggest('policy', groups.spaces)}")
        inner.wants_final_obs = True
        self.sim_device = inner.device
        self._actions: torch.Tensor | None = None
        self._returns = np.zeros(inner.num_envs)
        self._lengths = np.zeros(inner.num_envs, dtype=np.int64)
        super().__init__(inner.num_envs, groups["policy"], _bounded(inner.single_action_space))

    def __str__(self) -> str:
        return f"<{type(self).__name__}{self.env}>"

    __repr__ = __str__

    @classmethod
    def class_name(cls) -> str:
        """Name of the wrapper."""
        return cls.__name__

    @property
    def _inner(self) -> ManagerBasedRLEnv:
        return self.env.unwrapped  # type: ignore[return-value]

    @property
    def unwrapped(self) -> ManagerBasedRLEnv:  # type: ignore[override]
        """The environment inside all wrappers."""
        return self._inner

    def get_episode_rewards(self) -> list[float]:
        """Sums of rewards of the running episodes."""
        return self._returns.tolist()

    def get_episode_lengths(self) -> list[int]:
        """Lengths of the running episodes in steps."""
        return self._lengths.tolist()

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Seed the environments, which share their random numbers; None draws a seed. Returns it once for each."""
        return [self._inner.seed(-1 if seed is None else seed)] * self.num_envs

    def reset(self) -> Any:
        """Reset all environments; returns observations."""
        obs, _ = self.env.reset()
        self._returns[:] = 0.0
        self._lengths[:] = 0
        return _to_numpy(obs["policy"])

    def step_async(self, actions: np.ndarray | torch.Tensor) -> None:
        """Take the actions of :meth:`step_wait`, shape (num_envs, action_dim)."""
        self._actions = torch.as_tensor(actions, dtype=torch.float32, device=self.sim_device)

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Step all environments.

        Returns:
            Observations, rewards, dones and one info for each environment. Where an episode ended, the info holds
            ``episode`` (return ``r``, length ``l``), ``TimeLimit.truncated`` and ``terminal_observation``.
        """
        result: Any = self.env.step(self._actions)
        obs, rewards, terminated, truncated, extras = result
        check_step(self._inner, obs, rewards, extras)
        dones = (terminated | truncated).cpu().numpy()
        # Stable-Baselines3 adds to the rewards in place.
        rewards = rewards.cpu().numpy().copy()
        self._returns += rewards
        self._lengths += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        ended = dones.nonzero()[0]
        if len(ended):
            cut = (truncated & ~terminated).cpu().numpy()
            if self._inner.cfg.is_finite_horizon:
                cut[:] = False
            final = _to_numpy(extras["final_obs"]["policy"])
            for idx in ended:
                info = infos[idx]
                info["episode"] = {"r": float(self._returns[idx]), "l": int(self._lengths[idx])}
                if not self.fast_variant:
                    info["episode"].update(extras["log"])
                info["TimeLimit.truncated"] = bool(cut[idx])
                info["terminal_observation"] = (
                    {key: value[idx] for key, value in final.items()} if isinstance(final, dict) else final[idx]
                )
            self._returns[ended] = 0.0
            self._lengths[ended] = 0
        return _to_numpy(obs["policy"]), rewards, dones, infos

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute for each environment: the entries of a tensor with one for each, otherwise the same value."""
        ids = list(self._get_indices(indices))
        value = self._attribute(attr_name)
        if isinstance(value, torch.Tensor) and value.ndim and len(value) == self.num_envs:
            array = value.cpu().numpy()
            return [array[idx] for idx in ids]
        return [value] * len(ids)

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of the environments, which are one object.

        Raises:
            ConfigError: it is asked for some environments only.
        """
        if indices is not None:
            raise ConfigError(f"set_attr('{attr_name}'): the environments are one object; leave indices out")
        setattr(self._inner, attr_name, value)

    def env_method(self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any) -> list[Any]:
        """Call a method of the environments, which are one object, once; returns its result for each."""
        result = self._attribute(method_name)(*method_args, **method_kwargs)
        return [result] * len(list(self._get_indices(indices)))

    def env_is_wrapped(self, wrapper_class: type[gym.Wrapper], indices: Any = None) -> list[bool]:
        """Whether ``env`` is inside a wrapper of this class."""
        env: Any = self.env
        while isinstance(env, gym.Wrapper) and not isinstance(env, wrapper_class):
            env = env.env
        return [isinstance(env, wrapper_class)] * len(list(self._get_indices(indices)))

    def get_images(self) -> Sequence[np.ndarray | None]:
        """The one frame that the environments are drawn in."""
        return [self.env.render()]  # type: ignore[list-item]

    def _attribute(self, name: str) -> Any:
        """An attribute of ``env`` or what is inside. For VecEnv's base class before everything is set up, too."""
        return self.env.get_wrapper_attr(name)


class LogCallback(BaseCallback):
    """Records the environment's log (rewards, terminations, metrics), averaged over each rollout's ended episodes."""

    def __init__(self) -> None:
        super().__init__()
        self._logs = EpisodeLogs()

    def _on_step(self) -> bool:
        dones = self.locals["dones"]
        if np.any(dones):
            self._logs.add(self.training_env.get_attr("extras")[0], torch.from_numpy(dones.astype(bool)))
        return True

    def _on_rollout_end(self) -> None:
        for key, value in self._logs.means().items():
            self.logger.record(key if "/" in key else f"Episode/{key}", value)
        self._logs.clear()


def _bounded(space: gym.Space) -> gym.Space:
    if isinstance(space, gym.spaces.Box) and not space.is_bounded("both"):
        return gym.spaces.Box(-ACTION_BOUND, ACTION_BOUND, space.shape)
    return space


def _to_numpy(obs: torch.Tensor | dict[str, torch.Tensor]) -> Any:
    if isinstance(obs, dict):
        return {key: value.cpu().numpy() for key, value in obs.items()}
    return obs.cpu().numpy()
