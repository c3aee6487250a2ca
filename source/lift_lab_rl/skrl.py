"""skrl: environment wrapper. Needs the extra ``skrl``."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import torch

from lift_lab.utils.errors import ConfigError, suggest

from .nonfinite import check_step
from .optional_packages import missing_package

try:
    import skrl
    from skrl.envs.wrappers.torch.isaaclab_envs import IsaacLabWrapper
    from skrl.trainers.torch import ParallelTrainer, Trainer
    from skrl.utils.spaces.torch import flatten_tensorized_space, tensorize_space
except ModuleNotFoundError as error:
    raise missing_package("skrl", "skrl") from error

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedRLEnv


class SkrlVecEnvWrapper(IsaacLabWrapper):
    """Wraps a :class:`~lift_lab.envs.ManagerBasedRLEnv` for skrl (Isaac Lab's ``SkrlVecEnvWrapper``).

    Observations are the group ``policy``. States, for an asymmetric critic, are the group ``critic`` where there is
    one.

    Unlike in skrl's own wrapper, the environment's random numbers follow the environment's seed (not 0). A finite
    horizon counts as termination, so it is not bootstrapped. Rewards are a copy, which agents may change.

    Agents of skrl's trainers get the last observation of an episode that ended as its next observation. skrl's own
    wrapper gives them the first observation of the next episode. An agent with ``time_limit_bootstrap: false`` takes a
    time limit as a termination; skrl 2.1.1 alone would let returns run on into the next episode.

    Attributes:
        final_observations: observations and states (None without a group ``critic``) of all environments before the
            resets of the last step. Only the rows of environments whose episode ended are valid. None where no episode
            ended, or no trainer has asked for them.
    """

    final_observations: tuple[torch.Tensor, torch.Tensor | None] | None = None

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
        inner: ManagerBasedRLEnv = env.unwrapped
        if inner.cfg.seed is not None:
            skrl.config.torch.key = inner.cfg.seed
        super().__init__(env)
        if inner.cfg.seed is None:
            self._seed = None
        self._finite_horizon = inner.cfg.is_finite_horizon
        _extend_trainers()

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
        final = extras.get("final_obs")
        self.final_observations = None if final is None else self._flatten(final)
        if self._finite_horizon:
            terminated, truncated = terminated | truncated, torch.zeros_like(truncated)
        return obs, rewards.clone(), terminated, truncated, extras

    def give_final_observations(self) -> None:
        """Let each step in which episodes end fill :attr:`final_observations`."""
        self.unwrapped.wants_final_obs = True

    def _flatten(self, groups: dict[str, Any]) -> tuple[torch.Tensor, torch.Tensor | None]:
        """Observations and states in skrl's form: one row an environment."""
        obs: Any = flatten_tensorized_space(tensorize_space(self.observation_space, groups["policy"]))
        states: Any = None
        if "critic" in groups:
            states = flatten_tensorized_space(tensorize_space(self.state_space, groups["critic"]))
        return obs, states


# -- last observations for agents


def _extend_trainers() -> None:
    """Let skrl's trainers hand last observations to their agents, where the environment is ours.

    skrl knows environment and agent together in its trainers only, and has no place to register something there. So
    their constructor is replaced, once.
    """
    build = Trainer.__init__
    if not hasattr(build, "__wrapped__"):
        Trainer.__init__ = _recording_last_observations(build)


def _recording_last_observations(build: Callable[..., None]) -> Callable[..., None]:
    @functools.wraps(build)
    def build_trainer(trainer: Any, *args: Any, **kwargs: Any) -> None:
        build(trainer, *args, **kwargs)
        env = trainer.env
        if not isinstance(env, SkrlVecEnvWrapper):
            return
        if isinstance(trainer, ParallelTrainer):
            raise ConfigError(
                "skrl's ParallelTrainer runs agents in other processes, which do not get the last observations of "
                "episodes: use SequentialTrainer"
            )
        env.give_final_observations()
        agents = trainer.agents if trainer.num_simultaneous_agents > 1 else [trainer.agents]
        for agent, rows in zip(agents, trainer.scopes, strict=True):
            agent.record_transition = _recording(agent, env, slice(*rows))

    return build_trainer


def _recording(agent: Any, env: SkrlVecEnvWrapper, rows: slice) -> Callable[..., None]:
    """The agent's ``record_transition``, with the last observation of an episode that ended as its next one.

    Args:
        agent: skrl's agent.
        env: environment that it acts in.
        rows: the agent's environments.
    """
    record = functools.partial(type(agent).record_transition, agent)
    bootstraps = getattr(agent.cfg, "time_limit_bootstrap", True)

    def record_transition(
        *,
        next_observations: torch.Tensor,
        next_states: torch.Tensor | None,
        terminated: torch.Tensor,
        truncated: torch.Tensor,
        **others: Any,
    ) -> None:
        ended = terminated | truncated
        if env.final_observations is not None:
            obs, states = env.final_observations
            next_observations = torch.where(ended, obs[rows], next_observations)
            if states is not None and next_states is not None:
                next_states = torch.where(ended, states[rows], next_states)
        record(
            next_observations=next_observations,
            next_states=next_states,
            terminated=terminated if bootstraps else ended,
            truncated=truncated,
            **others,
        )

    return record_transition
