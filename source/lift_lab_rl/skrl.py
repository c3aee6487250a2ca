"""skrl: environment wrapper. Needs the extra ``skrl``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import gymnasium as gym
import torch

from lift_lab.utils.errors import ConfigError, suggest

from .extras import missing_package
from .nonfinite import check_step

try:
    import skrl
    from skrl.envs.wrappers.torch.isaaclab_envs import IsaacLabWrapper
except ModuleNotFoundError as error:
    raise missing_package("skrl") from error

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class SkrlVecEnvWrapper(IsaacLabWrapper):
    """Wraps a :class:`~lift_lab.envs.ManagerBasedRLEnv` for skrl (Isaac Lab's ``SkrlVecEnvWrapper``).

    Observations are the group ``policy``; states, for an asymmetric critic, the group ``critic`` where there is one.
    Unlike skrl's own wrapper: the environment's random numbers follow the environment's seed (not 0); a finite
    horizon counts as termination, so that it is not bootstrapped; rewards are a copy, which agents may change.
    """

    def __init__(self, env: gym.Env, ml_framework: str = "torch", wrapper: str = "isaaclab"):
        """Wrap ``env``.

        Args:
            env: environment, possibly inside gymnasium wrappers.
            ml_framework: Isaac Lab's; ``"torch"``.
            wrapper: Isaac Lab's; ``"auto"``, ``"isaaclab"`` or ``"isaaclab-single-agent"``, which are the same here.

        Raises:
            ConfigError: the environment is not manager-based, or another framework or wrapper is asked for.
        """
        from lift_lab.envs import ManagerBasedRLEnv

        if not isinstance(env.unwrapped, ManagerBasedRLEnv):
            raise ConfigError(f"expected a ManagerBasedRLEnv, got {type(env.unwrapped).__name__}")
        if ml_framework != "torch":
            raise ConfigError(f"unknown ml_framework '{ml_framework}': environments here are torch's; use 'torch'")
        wrappers = ("auto", "isaaclab", "isaaclab-single-agent")
        if wrapper not in wrappers:
            raise ConfigError(f"unknown wrapper '{wrapper}': {suggest(wrapper, wrappers)}")
        inner: ManagerBasedRLEnv = env.unwrapped  # type: ignore[assignment]
        if inner.cfg.seed is not None:
            skrl.config.torch.key = inner.cfg.seed
        super().__init__(env)
        if inner.cfg.seed is None:
            self._seed = None
        self._finite_horizon = inner.cfg.is_finite_horizon

    def step(self, actions: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor, torch.Tensor, Any]:
        """Step all environments.

        Args:
            actions: shape (num_envs, action_dim).

        Returns:
            Observations; rewards, terminated and truncated, each of shape (num_envs, 1); extras.
        """
        obs, rewards, terminated, truncated, extras = super().step(actions)
        inner = self._env.unwrapped
        check_step(inner, inner.obs_buf, inner.reward_buf, extras)
        if self._finite_horizon:
            terminated, truncated = terminated | truncated, torch.zeros_like(truncated)
        return obs, rewards.clone(), terminated, truncated, extras
