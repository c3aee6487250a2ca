"""Environment for reinforcement learning: adds rewards, terminations, commands and curricula to the base's managers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import gymnasium as gym
import numpy as np
import torch
from gymnasium.utils import seeding

from lift_lab.managers import CommandManager, CurriculumManager, MetricsManager, RewardManager, TerminationManager
from lift_lab.utils.errors import ConfigError, suggest
from lift_lab.utils.indexing import fill_rows, where_true

from .arguments import action_tensor, config_of_arguments
from .common import VecEnvObs, VecEnvStepReturn
from .frame_capture import FrameCapture, render_view
from .grad_mode import in_any_grad_mode
from .manager_based_env import ManagerBasedEnv
from .manager_based_rl_env_cfg import ManagerBasedRLEnvCfg

if TYPE_CHECKING:
    from lift_lab.sim.physics.base import Physics

__all__ = [
    "ManagerBasedRLEnv",
]


class ManagerBasedRLEnv(ManagerBasedEnv, gym.Env):
    """A batch of environments that reset themselves: call :meth:`reset` once, then :meth:`step`.

    The observation returned with a done flag is already that of the next episode.
    """

    is_vector_env: ClassVar[bool] = True
    auto_reset_failed = True
    metadata: dict[str, Any] = {  # gymnasium's
        "render_modes": [None, "rgb_array"],
        "autoreset_mode": gym.vector.AutoresetMode.SAME_STEP,
    }

    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"wants_final_obs"})

    cfg: ManagerBasedRLEnvCfg

    common_step_counter: int
    """Environment steps taken since construction; a resumed training sets it."""
    episode_length_buf: torch.Tensor
    """Steps taken in the current episode, shape (num_envs,)."""
    reset_buf: torch.Tensor
    """Whether the last step ended the episode, shape (num_envs,)."""
    reset_terminated: torch.Tensor
    """Whether it did for another reason than time, shape (num_envs,)."""
    reset_time_outs: torch.Tensor
    """Whether time ended it, shape (num_envs,)."""
    reward_buf: torch.Tensor
    """Reward of the last step, shape (num_envs,)."""
    wants_final_obs: bool = False
    """Whether a step in which episodes end puts their last observations into ``extras["final_obs"]``: like the
    observations that it returns, but before the resets. Only the rows of environments whose episode ended mean
    anything. Libraries' wrappers set it; it costs one more pass over the observation terms in such steps."""

    def __init__(
        self,
        cfg: ManagerBasedRLEnvCfg | None = None,
        render_mode: str | None = None,
        num_envs: int | None = None,
        device: str | None = None,
        **kwargs: Any,
    ):
        """Build the environment.

        Args:
            cfg: the config; None for a new one of ``env_cfg_entry_point``.
            render_mode: None, or ``"rgb_array"`` for frames.
            num_envs: number of environments, in a copy of the config; None for the config's.
            device: torch device, in a copy of the config; None for the config's.
            **kwargs: what the task was registered with.

        Raises:
            TypeError: the config lacks values; the message lists the path of each.
            ConfigError: an unknown argument or render mode, or something in the config that cannot be built.
        """
        modes = [mode for mode in self.metadata["render_modes"] if mode]
        if render_mode is not None and render_mode not in modes:
            raise ConfigError(f"unknown render_mode '{render_mode}': {suggest(render_mode, modes)}")
        self.render_mode = render_mode
        self._capture: FrameCapture | None = None
        super().__init__(config_of_arguments(cfg, num_envs, device, kwargs))
        self.metadata = {**type(self).metadata, "render_fps": 1.0 / self.step_dt}

    def _create_buffers(self) -> None:
        self.common_step_counter = 0
        num_envs, device = self.num_envs, self.device
        self.episode_length_buf = torch.zeros(num_envs, dtype=torch.long, device=device)
        self.reset_buf = torch.zeros(num_envs, dtype=torch.bool, device=device)
        self.reset_terminated = torch.zeros_like(self.reset_buf)
        self.reset_time_outs = torch.zeros_like(self.reset_buf)
        self.reward_buf = torch.zeros(num_envs, device=device)
        self._failures: dict[str, torch.Tensor] = {}  # in the present step: which environments, by kind
        self._failure_counts: dict[str, Any] = dict.fromkeys(("nonfinite", "overflow"), 0.0)

    def load_managers(self) -> None:
        """Create the managers that need the running simulation, each after those that it reads."""
        self.command_manager: CommandManager = CommandManager(self.cfg.commands, self)
        super().load_managers()
        if not self.action_manager.total_action_dim:
            raise ConfigError("env.actions has no term: a policy needs something to decide")
        if not self.observation_manager.active_terms:
            raise ConfigError("env.observations has no group: a policy needs something to see")
        self.termination_manager: TerminationManager = TerminationManager(self.cfg.terminations, self)
        self.reward_manager: RewardManager = RewardManager(self.cfg.rewards, self)
        self.metrics_manager: MetricsManager = MetricsManager(self.cfg.metrics, self)
        self.curriculum_manager: CurriculumManager = CurriculumManager(self.cfg.curriculum, self)
        self._configure_gym_env_spaces()

    def _managers(self) -> list[Any]:
        return [
            *super()._managers(),
            self.command_manager,
            self.termination_manager,
            self.reward_manager,
            self.metrics_manager,
            self.curriculum_manager,
        ]

    # -- what it is

    @property
    def max_episode_length_s(self) -> float:
        """Length of an episode in s."""
        return self.cfg.episode_length_s

    @property
    def max_episode_length(self) -> int:
        """Length of an episode in environment steps."""
        return math.ceil(self.max_episode_length_s / self.step_dt)

    def _configure_gym_env_spaces(self) -> None:
        """Set the spaces of one environment and of the batch."""
        manager = self.observation_manager
        groups: dict[str, gym.Space] = {}
        for group, names in manager.active_terms.items():
            dims: Any = manager.group_obs_dim[group]
            if manager.group_obs_concatenate[group]:
                groups[group] = _unbounded(dims)
                continue
            terms = {}
            for name, dim, cfg in zip(names, dims, manager.group_obs_term_cfgs[group], strict=True):
                terms[name] = _unbounded(dim) if cfg.clip is None else gym.spaces.Box(*cfg.clip, shape=dim)
            groups[group] = gym.spaces.Dict(terms)
        self.single_observation_space = gym.spaces.Dict(groups)
        self.single_action_space = _unbounded((self.action_manager.total_action_dim,))
        self.observation_space = gym.vector.utils.batch_space(self.single_observation_space, self.num_envs)
        self.action_space = gym.vector.utils.batch_space(self.single_action_space, self.num_envs)

    @property
    def unwrapped(self) -> ManagerBasedRLEnv:
        """This environment."""
        return self

    # -- running

    def reset(  # pyright: ignore[reportIncompatibleMethodOverride]  # by position, too, as in Isaac Lab
        self,
        seed: int | None = None,
        env_ids: Sequence[int] | torch.Tensor | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[VecEnvObs, dict[str, Any]]:
        """Reset environments and observe; see :meth:`ManagerBasedEnv.reset`.

        A seed goes to ``self.np_random`` too, gymnasium's generator, which nothing in this project draws from.
        """
        if seed is not None:
            seed = self.seed(seed)
            self._np_random, self._np_random_seed = seeding.np_random(seed)
        return super().reset(seed, env_ids, options)

    @in_any_grad_mode
    def step(self, action: torch.Tensor | np.ndarray | Sequence[Any]) -> VecEnvStepReturn:  # type: ignore[override]
        """Advance by one environment step and reset the environments whose episode ended.

        Rewards and terminations read the kinematics of the state just reached. The observations of environments that
        were reset read their new state. Rewards and metrics come after terminations, which they may read, and before
        resets. Commands come after resets, so a new episode's command is current in its first observation.

        Args:
            action: shape (num_envs, action_dim).

        Returns:
            Observations, rewards, terminated, truncated and extras.

        Raises:
            ValueError: the action has another shape, or is not made of numbers.
        """
        dt = self.step_dt
        self.action_manager.process_action(action_tensor(action, self.device))
        self.recorder_manager.record_pre_step()
        self._failures = {}
        self._step_physics()

        self.episode_length_buf += 1
        self.common_step_counter += 1
        self.step_cache = {}
        try:
            self.reset_buf = self.termination_manager.compute()
            self.reset_terminated = self.termination_manager.terminated
            self.reset_time_outs = self.termination_manager.time_outs
            self.reward_buf = self.reward_manager.compute(dt=dt)
            if self._failures:
                self._end_failed_episodes()
            self.metrics_manager.compute()
        finally:
            self.step_cache = None
        if self._records:
            self.obs_buf = self.observation_manager.compute()
            self.recorder_manager.record_post_step()

        reset_env_ids = self._ended_episodes()
        self.extras.pop("final_obs", None)
        if len(reset_env_ids) > 0:
            if self._failures:
                self.reward_manager.leave_out_last_step(self._failed)
            if self.wants_final_obs:
                self.extras["final_obs"] = self.observation_manager.preview()
            self.recorder_manager.record_pre_reset(reset_env_ids)
            self._reset_idx(reset_env_ids)
            self.scene.start_episodes(reset_env_ids)
            self._refresh(reset_env_ids)
            self.recorder_manager.record_post_reset(reset_env_ids)

        self.command_manager.compute(dt=dt)
        if self._has_interval_events:
            self.event_manager.apply(mode="interval", dt=dt)
        self.prefetched = {}
        self.obs_buf = self._observe()
        return self.obs_buf, self.reward_buf, self.reset_terminated, self.reset_time_outs, self.extras

    def render(self, recompute: bool = False) -> np.ndarray | None:
        """Draw the current state from the camera of ``cfg.viewer``.

        Args:
            recompute: Isaac Lab's argument. It has no effect, since every call draws a new frame.

        Returns:
            RGB image, shape (height, width, 3), uint8; None when ``render_mode`` is None.

        Raises:
            PhysicsError: there is no OpenGL library to draw with.
            ConfigError: the viewer names an environment, origin, asset, body or camera that does not exist.
        """
        if self.render_mode != "rgb_array":
            return None
        if self._capture is None or not self._capture.fits(self.cfg.viewer):
            self._capture = FrameCapture(self)
        return self.sim.render(render_view(self, self._capture))

    # -- parts of a step

    def _check_health(self, physics: Physics) -> None:
        """Take note of environments in which the physics failed: their episodes end in :meth:`_end_failed_episodes`.

        The engine has put them into the model's default state, so no term ever reads their numbers.
        """
        health = physics.health()
        if health.none_failed:
            return
        for kind in self._failure_counts:
            failed, before = getattr(health, kind), self._failures.get(kind)
            self._failures[kind] = failed if before is None else before | failed

    @property
    def physics_failed(self) -> torch.Tensor | None:
        """In which environments the physics failed in the present step, shape (num_envs,); None where it surely did in
        none."""
        return self._failed if self._failures else None

    @property
    def _failed(self) -> torch.Tensor:
        return self._failures["nonfinite"] | self._failures["overflow"]

    def _end_failed_episodes(self) -> None:
        """Count environments in which the physics failed as terminated, once a step, with no reward for this step."""
        for kind, envs in self._failures.items():
            self._failure_counts[kind] = self._failure_counts[kind] + envs.sum()
        failed = self._failed
        self.reward_buf = self.reward_buf.masked_fill(failed, 0.0)
        self.reset_buf = self.reset_buf | failed
        self.reset_terminated = self.reset_terminated | failed
        self.reset_time_outs = self.reset_time_outs & ~failed

    def _ended_episodes(self) -> torch.Tensor:
        """Ids of the environments whose episode ended.

        With an engine for which the host should not wait, the same question answers what the managers need to know
        in this step.
        """
        if not self.sim.physics.is_asynchronous:
            return self.reset_buf.nonzero().squeeze(-1)
        masks = {"ended": self.reset_buf}
        for manager in (self.command_manager, self.event_manager, self.metrics_manager):
            masks |= manager.masks(self.step_dt, self.reset_buf)
        self.prefetched = dict(zip(masks, where_true(list(masks.values())), strict=True))
        return self.prefetched.pop("ended")

    def _reset_idx(self, env_ids: torch.Tensor) -> None:
        self.curriculum_manager.compute(env_ids=env_ids)
        self._reset_scene(env_ids)
        log: dict[str, Any] = {}
        self.extras["log"] = log
        for manager in (
            self.observation_manager,
            self.action_manager,
            self.reward_manager,
            self.curriculum_manager,
            self.metrics_manager,  # before the commands, which may leave the new episode out of the means
            self.command_manager,
            self.event_manager,
            self.termination_manager,
            self.recorder_manager,
        ):
            log.update(manager.reset(env_ids))
        self.extras["log_counts"] = self.metrics_manager.log_counts
        for kind, count in self._failure_counts.items():
            log[f"Metrics/physics/{kind}"] = count
            self._failure_counts[kind] = 0.0
        fill_rows(self.episode_length_buf, env_ids, 0)


def _unbounded(shape: tuple[int, ...]) -> gym.spaces.Box:
    return gym.spaces.Box(low=-np.inf, high=np.inf, shape=shape)
