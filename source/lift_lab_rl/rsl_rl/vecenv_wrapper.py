"""Wrapper of an environment for rsl_rl."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium as gym
import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class RslRlVecEnvWrapper(VecEnv):
    """Wraps a :class:`~lift_lab.envs.ManagerBasedRLEnv` for rsl_rl 5 (Isaac Lab's ``RslRlVecEnvWrapper``).

    Has to be the outermost wrapper. Observations are a TensorDict with one entry for each observation group.
    """

    def __init__(self, env: gym.Env, clip_actions: float | None = None):
        """Wrap ``env`` and reset it.

        Args:
            env: environment, possibly inside gymnasium wrappers.
            clip_actions: actions are clipped to plus and minus this value; None for not at all.

        Raises:
            ValueError: the environment is not manager-based.
        """
        from lift_lab.envs import ManagerBasedRLEnv

        if not isinstance(env.unwrapped, ManagerBasedRLEnv):
            raise ValueError(f"expected a ManagerBasedRLEnv, got {type(env.unwrapped).__name__}")
        self.env = env
        self.clip_actions = clip_actions
        self.num_envs = self.unwrapped.num_envs
        self.device = self.unwrapped.device
        self.max_episode_length = self.unwrapped.max_episode_length
        self.num_actions = self.unwrapped.action_manager.total_action_dim
        if clip_actions is not None:
            self.unwrapped.single_action_space = gym.spaces.Box(-clip_actions, clip_actions, (self.num_actions,))
            self.unwrapped.action_space = gym.vector.utils.batch_space(
                self.unwrapped.single_action_space, self.num_envs
            )
        self._obs: dict[str, Any] = {}
        self.reset()

    def __str__(self) -> str:
        return f"<{type(self).__name__}{self.env}>"

    __repr__ = __str__

    @classmethod
    def class_name(cls) -> str:
        """Name of the wrapper."""
        return cls.__name__

    @property
    def unwrapped(self) -> ManagerBasedRLEnv:
        """The environment inside all wrappers."""
        return self.env.unwrapped  # type: ignore[return-value]

    @property
    def cfg(self) -> Any:
        """Configuration of the environment."""
        return self.unwrapped.cfg

    @property
    def render_mode(self) -> str | None:
        """Render mode of the environment."""
        return self.env.render_mode

    @property
    def observation_space(self) -> gym.Space:
        """Observation space of all environments together."""
        return self.env.observation_space

    @property
    def action_space(self) -> gym.Space:
        """Action space of all environments together."""
        return self.env.action_space

    @property
    def episode_length_buf(self) -> torch.Tensor:
        """Steps since the last reset, shape (num_envs,). May be set, to start episodes at different ages."""
        return self.unwrapped.episode_length_buf

    @episode_length_buf.setter
    def episode_length_buf(self, value: torch.Tensor) -> None:  # pyright: ignore[reportIncompatibleVariableOverride]
        self.unwrapped.episode_length_buf = value

    def seed(self, seed: int = -1) -> int:
        """Seed the environment; returns the seed."""
        return self.unwrapped.seed(seed)

    def reset(self) -> tuple[TensorDict, dict]:
        """Reset all environments."""
        self._obs, extras = self.env.reset()
        return self.get_observations(), extras

    def get_observations(self) -> TensorDict:
        """The observations that the last reset or step returned; nothing is computed (or drawn) again."""
        return TensorDict(self._obs, batch_size=[self.num_envs])

    def restore_observations(self, obs: dict[str, torch.Tensor]) -> None:
        """Make ``obs`` what :meth:`get_observations` returns, when a run continues."""
        self._obs = obs

    def step(self, actions: torch.Tensor) -> tuple[TensorDict, torch.Tensor, torch.Tensor, dict]:
        """Step all environments.

        Args:
            actions: shape (num_envs, num_actions).

        Returns:
            Observations; rewards, shape (num_envs,); dones, shape (num_envs,), 0 or 1; extras with ``time_outs``
            (unless the task has a finite horizon), ``log``, and ``final_obs`` where the environment is asked for it
            (:attr:`~lift_lab.envs.ManagerBasedRLEnv.wants_final_obs`).
        """
        if self.clip_actions is not None:
            actions = actions.clamp(-self.clip_actions, self.clip_actions)
        result: Any = self.env.step(actions)
        self._obs, rewards, terminated, truncated, extras = result
        dones = (terminated | truncated).to(torch.long)
        # A finite horizon is part of the task: reaching it is worth nothing more, so it is not bootstrapped.
        if not self.cfg.is_finite_horizon:
            extras["time_outs"] = truncated
        return self.get_observations(), rewards, dones, extras

    def close(self) -> None:
        """Close the environment."""
        self.env.close()
