"""Policies of rsl_rl for scripts and notebooks."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import torch
from tensordict import TensorDict


class LoadedPolicy:
    """A trained policy. Call it with the observations that ``env.step`` returns."""

    def __init__(self, policy: Any, device: str, clip_actions: float | None):
        """Keep a policy.

        Args:
            policy: of a runner, for observations in a TensorDict.
            device: device of the actions.
            clip_actions: actions are clipped to plus and minus this value; None for not at all.
        """
        self._policy, self._device, self._clip_actions = policy, device, clip_actions

    def __call__(self, obs: Any) -> torch.Tensor:
        """The actions for observations by group, shape (num_envs, num_actions)."""
        with torch.inference_mode():
            if not isinstance(obs, TensorDict):
                obs = TensorDict(obs, batch_size=[next(iter(obs.values())).shape[0]])
            actions = self._policy(obs).to(self._device)
        return actions if self._clip_actions is None else actions.clamp(-self._clip_actions, self._clip_actions)

    def reset(self, dones: torch.Tensor) -> None:
        """Forget the past of environments whose episode ended, shape (num_envs,)."""
        self._policy.reset(dones)


def load_policy(
    env: gym.Env, checkpoint: str = "pretrained", agent_cfg_entry_point: str = "rsl_rl_cfg_entry_point"
) -> LoadedPolicy:
    """Load a policy that rsl_rl has trained, and reset the environment.

    Args:
        env: made by ``gym.make`` with the id of a task.
        checkpoint: path of a file or of a run's folder, ``latest``, ``best``, ``pretrained``, or a regular expression
            of file names.
        agent_cfg_entry_point: key of the agent's configuration.

    Raises:
        FileError: there is no such checkpoint, or it is damaged.
        ConfigError: it is of other networks, or the environment was not made by ``gym.make``.
    """
    from lift_lab.utils.errors import ConfigError
    from lift_lab_rl.rsl_rl import LiftLabRunner, RslRlVecEnvWrapper, to_rsl_rl

    from .parse_cfg import load_cfg_from_registry
    from .runs import find_checkpoint

    inner: Any = env.unwrapped
    if env.spec is None:
        raise ConfigError("load_policy needs an environment of gym.make, which knows its task's id")
    agent: Any = load_cfg_from_registry(env.spec.id, agent_cfg_entry_point)
    agent.device = inner.device
    wrapped = RslRlVecEnvWrapper(env, clip_actions=agent.clip_actions)
    runner = LiftLabRunner(wrapped, to_rsl_rl(agent, wrapped.get_observations().keys()), None, inner.device)
    runner.load_policy(str(find_checkpoint(agent, checkpoint, agent.load_run, env.spec.id)))
    return LoadedPolicy(runner.get_inference_policy(device=inner.device), inner.device, agent.clip_actions)
