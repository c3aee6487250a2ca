"""A manager-based environment as gymnasium's ``VectorEnv``: what ``gymnasium.make_vec`` returns.

For gymnasium's vector wrappers and for libraries written against them: numpy arrays, and the contract of
``AutoresetMode.SAME_STEP``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium.vector import VectorEnv

from lift_lab.utils.errors import ConfigError, suggest

from .arguments import config_of_arguments
from .manager_based_rl_env import ManagerBasedRLEnv

if TYPE_CHECKING:
    from .manager_based_rl_env_cfg import ManagerBasedRLEnvCfg

__all__ = [
    "ManagerBasedRLVectorEnv",
]


class ManagerBasedRLVectorEnv(VectorEnv):
    """Gymnasium's vector interface of a :class:`ManagerBasedRLEnv`, with numpy arrays.

    Episodes that end are reset within the step that ends them. Then ``infos["final_obs"]`` holds their last
    observations, and ``infos["log"]`` the log of the resets. Both have gymnasium's masks (``_final_obs``, ``_log``).
    """

    def __init__(
        self,
        cfg: ManagerBasedRLEnvCfg | None = None,
        num_envs: int | None = None,
        render_mode: str | None = None,
        observation_group: str | None = None,
        device: str | None = None,
        **kwargs: Any,
    ):
        """Build the environment.

        Args:
            cfg: the config; None for a new one of ``env_cfg_entry_point``. It is not changed.
            num_envs: number of environments; None for the config's.
            render_mode: None, or ``"rgb_array"`` for frames.
            observation_group: group to hand out alone; None for a dict of all groups.
            device: torch device; None for the config's.
            **kwargs: what the task was registered with.

        Raises:
            ConfigError: there is no config, no group of that name, or an unknown argument.
        """
        cfg = None if cfg is None else cfg.copy()
        cfg = config_of_arguments(cfg, num_envs, device, kwargs, observation_group=True)
        self.env = ManagerBasedRLEnv(cfg, render_mode=render_mode)
        self.env.wants_final_obs = True
        self.num_envs = self.env.num_envs
        self.render_mode = render_mode
        self.metadata = self.env.metadata
        self._group = observation_group
        groups: dict[str, Any] = self.env.single_observation_space.spaces
        if observation_group is not None and observation_group not in groups:
            self.env.close()
            raise ConfigError(f"no observation group '{observation_group}'; {suggest(observation_group, groups)}")
        self.single_observation_space = self._choose(self.env.single_observation_space)
        self.single_action_space = self.env.single_action_space
        self.observation_space = self._choose(self.env.observation_space)
        self.action_space = self.env.action_space

    def _choose(self, groups: Any) -> Any:
        return groups if self._group is None else groups[self._group]

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Reset environments.

        Args:
            seed: seed of all random numbers, which the environments share.
            options: ``reset_mask``, a boolean array of shape (num_envs,), resets only some.

        Returns:
            Observations of all environments, and infos.

        Raises:
            ConfigError: a list of seeds, or a mask of another kind.
        """
        if seed is not None and not isinstance(seed, (int, np.integer)):
            raise ConfigError("reset takes one seed: the environments share their random numbers")
        if seed is not None and seed >= 0:
            super().reset(seed=int(seed))
        env_ids = None
        if options is not None and "reset_mask" in options:
            mask = options["reset_mask"]
            if not isinstance(mask, np.ndarray) or mask.dtype != np.bool_ or mask.shape != (self.num_envs,):
                raise ConfigError(f"options['reset_mask'] must be a boolean array of shape ({self.num_envs},)")
            env_ids = mask.nonzero()[0].tolist()
        obs, extras = self.env.reset(seed=None if seed is None else int(seed), env_ids=env_ids)
        done = np.ones(self.num_envs, dtype=np.bool_) if env_ids is None else options["reset_mask"]  # type: ignore[index]
        return _to_numpy(self._choose(obs)), {"log": _log(extras, done), "_log": done.copy()}

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Step all environments.

        Args:
            actions: shape (num_envs, action_dim).

        Returns:
            Observations, rewards, terminated, truncated and infos.
        """
        obs, rewards, terminated, truncated, extras = self.env.step(actions)
        infos: dict[str, Any] = {}
        done = (terminated | truncated).cpu().numpy()
        if done.any():
            final = _to_numpy(self._choose(extras["final_obs"]))
            rows = np.full(self.num_envs, None, dtype=object)
            for idx in done.nonzero()[0]:
                rows[idx] = _row(final, idx)
            infos = {"final_obs": rows, "_final_obs": done, "log": _log(extras, done), "_log": done.copy()}
        return (
            _to_numpy(self._choose(obs)),
            rewards.cpu().numpy().astype(np.float64),
            terminated.cpu().numpy().copy(),
            truncated.cpu().numpy().copy(),
            infos,
        )

    def render(self) -> tuple[np.ndarray, ...] | None:
        """The frame of ``cfg.viewer``, once for each environment: gymnasium expects so many, only one is drawn.

        With gymnasium's ``RecordVideo`` for vector environments set ``record_first_only=True``.
        """
        frame = self.env.render()
        return None if frame is None else (frame,) * self.num_envs

    def close_extras(self, **kwargs: Any) -> None:
        """Close the environment; part of ``close``, which may be called again."""
        self.env.close()

    def __str__(self) -> str:
        return f"{type(self).__name__}(num_envs={self.num_envs})"


def _to_numpy(obs: Any) -> Any:
    if isinstance(obs, dict):
        return {key: _to_numpy(value) for key, value in obs.items()}
    return obs.cpu().numpy()


def _row(obs: Any, idx: Any) -> Any:
    return {key: _row(value, idx) for key, value in obs.items()} if isinstance(obs, dict) else obs[idx]


def _log(extras: dict[str, Any], done: np.ndarray) -> dict[str, np.ndarray]:
    """The log as gymnasium writes infos: an array for each key, with a mask of the rows that count."""
    found: dict[str, np.ndarray] = {}
    for key, value in extras.get("log", {}).items():
        found[key] = np.where(done, float(value), 0.0)
        found[f"_{key}"] = done.copy()
    return found
