"""Curves of a training run.

Everything that happens in a rollout is kept on the device and read once at its end, so that no step waits for a
transfer. Tags are Isaac Lab's and rsl_rl's; see :mod:`lift_lab_rl.scalar_names`.
"""

from __future__ import annotations

import statistics
from collections import deque
from pathlib import Path
from typing import Any

import torch
from rsl_rl.utils.log_writer import LogWriter
from rsl_rl.utils.utils import resolve_class

from lift_lab.utils.errors import ConfigError
from lift_lab_rl.curve_layout import layout
from lift_lab_rl.episode_logs import EpisodeLogs
from lift_lab_rl.scalar_names import SPREAD

from .curve_files import CurveWriter
from .progress import IterationReport

LAST_EPISODES = 100
"""Episodes that mean reward and length are taken over (rsl_rl's number)."""


class RunLogger:
    """Collects what happens in rollouts and writes it once an iteration.

    Attributes:
        writer: where curves go; None while nothing is open.
    """

    def __init__(self, cfg: dict[str, Any], env_cfg: Any, num_envs: int, device: str, log_dir: Path | None = None):
        """Open nothing yet.

        Args:
            cfg: what :func:`~lift_lab_rl.rsl_rl.cfg_conversion.to_rsl_rl` returns.
            env_cfg: the environment's configuration, for services that show it.
            num_envs: environments.
            device: device of the rewards.
            log_dir: folder of the run; None writes nothing.
        """
        self._cfg, self._env_cfg, self._log_dir = cfg, env_cfg, log_dir
        self.writer: Any = None
        self._total_time_s = 0.0
        self._last_returns: deque[float] = deque(maxlen=LAST_EPISODES)
        self._last_lengths: deque[float] = deque(maxlen=LAST_EPISODES)
        self._reward_sum = torch.zeros(num_envs, device=device)
        self._episode_length = torch.zeros(num_envs, device=device)
        # of the running rollout
        shape = (cfg["num_steps_per_env"], num_envs)
        self._rewards = torch.zeros(shape, device=device)
        self._returns = torch.zeros(shape, device=device)
        self._lengths = torch.zeros(shape, device=device)
        self._dones = torch.zeros(shape, dtype=torch.bool, device=device)
        self._logs = EpisodeLogs()
        self._step = 0
        self._curiosity = _Curiosity(shape, device) if cfg["algorithm"].get("rnd_cfg") else None

    # -- where curves go

    def open(self) -> None:
        """Open an event file that outlives a full disk, or a service.

        Raises:
            ConfigError: a package is missing.
        """
        if self._log_dir is None:
            return
        kind = self._cfg.get("logger", "tensorboard")
        if kind == "tensorboard":
            self.writer = CurveWriter(str(self._log_dir))
            self.writer.add_custom_scalars(layout())
            return
        try:
            writer_class, settings = resolve_class(kind)
        except ModuleNotFoundError as error:
            raise ConfigError(f"agent.logger: {error}") from error
        writer: Any = writer_class(log_dir=str(self._log_dir), **settings)
        self.writer = writer
        writer.store_config(self._env_cfg, self._cfg)
        if isinstance(writer, CurveWriter):
            writer.add_custom_scalars(layout())

    def save_model(self, path: str, iteration: int) -> None:
        """Send a checkpoint to a service."""
        if isinstance(self.writer, LogWriter):
            self.writer.save_model(path, iteration)

    def close(self) -> None:
        """Write and send the remaining values."""
        writer = self.writer
        if isinstance(writer, LogWriter):
            writer.stop()
        if self.writer is not None:
            self.writer.close()

    # -- a rollout

    def start_rollout(self) -> None:
        """Forget the rollout before."""
        self._logs.clear()
        self._step = 0

    def process_env_step(
        self,
        rewards: torch.Tensor,
        dones: torch.Tensor,
        extras: dict,
        intrinsic_rewards: torch.Tensor | None = None,
    ) -> None:
        """Add one environment step.

        Args:
            rewards: shape (num_envs,).
            dones: shape (num_envs,).
            extras: the step's; see :meth:`~lift_lab_rl.episode_logs.EpisodeLogs.add`.
            intrinsic_rewards: shape (num_envs,).
        """
        step, done = self._step, dones > 0
        self._rewards[step] = rewards
        total = rewards if intrinsic_rewards is None else rewards + intrinsic_rewards
        self._reward_sum += total
        self._episode_length += 1
        self._returns[step] = self._reward_sum
        self._lengths[step] = self._episode_length
        self._dones[step] = done
        self._logs.add(extras, self._dones[step])
        if self._curiosity is not None and intrinsic_rewards is not None:
            self._curiosity.add(step, intrinsic_rewards, done)
        self._reward_sum.masked_fill_(done, 0.0)
        self._episode_length.masked_fill_(done, 0.0)
        self._step = step + 1

    def logs(self) -> list[dict[str, Any]]:
        """The environment's logs of the running rollout."""
        return self._logs.entries()

    def log_iteration(
        self,
        report: IterationReport,
        losses: dict[str, float],
        rnd_weight: float | None = None,
    ) -> None:
        """Complete ``report`` with this rollout's episodes and write every curve.

        Args:
            report: times and counts of the iteration; gets its rewards, lengths and terms here.
            losses: mean losses.
            rnd_weight: weight of the intrinsic reward.
        """
        self._total_time_s += report.collect_s + report.learn_s
        used = slice(0, self._step)
        finished = self._dones[used]
        self._last_returns.extend(self._returns[used][finished].tolist())
        self._last_lengths.extend(self._lengths[used][finished].tolist())
        if self._curiosity is not None:
            self._curiosity.finish(finished)
        report.terms = self._logs.means()
        if self._last_returns:
            report.mean_reward = statistics.fmean(self._last_returns)
            report.mean_length = statistics.fmean(self._last_lengths)
        if self.writer is not None:
            writer = self.writer
            _add(writer, self._scalars(report, losses, rnd_weight), report.iteration)
            if isinstance(writer, LogWriter):
                for video in sorted(Path(str(self._log_dir)).glob("videos/*/[!.]*.mp4")):
                    writer.save_video(video, report.iteration)
            # A kill loses the running iteration at most.
            self.writer.flush()

    def log_scalars(self, scalars: dict[str, float], iteration: int) -> None:
        """Write further curves of an iteration."""
        if self.writer is not None:
            _add(self.writer, scalars, iteration)
            self.writer.flush()

    def _scalars(self, report: IterationReport, losses: dict[str, float], rnd_weight: float | None) -> dict[str, float]:
        tags = {(key if "/" in key else f"Episode/{key}"): value for key, value in report.terms.items()}
        tags |= {f"Loss/{key}": value for key, value in losses.items()}
        if "entropy" in losses:
            tags["Loss/entropy_loss"] = -report.entropy_coef * losses["entropy"]
            tags["Policy/entropy_coef"] = report.entropy_coef
        tags["Loss/learning_rate"] = report.learning_rate
        tags["Policy/mean_std"] = report.action_std
        tags["Perf/total_fps"] = report.steps / (report.collect_s + report.learn_s)
        tags["Perf/collection_time"] = report.collect_s
        tags["Perf/learning_time"] = report.learn_s
        tags["Perf/total_steps"] = report.total_steps
        if rnd_weight is not None:
            tags["Rnd/weight"] = rnd_weight
        rewards = self._rewards[: self._step]
        spread = torch.stack([rewards.mean(), rewards.max(), rewards.min()]).tolist()
        for kind, value in zip(SPREAD, spread, strict=True):
            tags[f"Train/{kind}_step_reward"] = value
        if report.mean_reward is not None and report.mean_length is not None:
            tags["Train/mean_reward"] = report.mean_reward
            tags["Train/max_reward"], tags["Train/min_reward"] = max(self._last_returns), min(self._last_returns)
            tags["Train/mean_episode_length"] = report.mean_length
            tags["Train/max_episode_length"] = max(self._last_lengths)
            tags["Train/min_episode_length"] = min(self._last_lengths)
            if self._curiosity is not None:
                intrinsic = self._curiosity.mean_return()
                tags["Rnd/mean_intrinsic_reward"] = intrinsic
                tags["Rnd/mean_extrinsic_reward"] = report.mean_reward - intrinsic
        return tags

    # -- continuing a run

    def state_dict(self) -> dict[str, Any]:
        """Running sums and the last episodes, as tensors and plain values."""
        of_curiosity = {} if self._curiosity is None else self._curiosity.state_dict()
        return {
            "returns": list(self._last_returns),
            "lengths": list(self._last_lengths),
            "reward_sum": self._reward_sum.cpu().clone(),
            "episode_length": self._episode_length.cpu().clone(),
            "total_time_s": self._total_time_s,
            **of_curiosity,
        }

    def forget_episodes(self) -> None:
        """Drop the last episodes, the running ones and the steps of a rollout that was broken off."""
        self._last_returns.clear()
        self._last_lengths.clear()
        self._reward_sum.zero_()
        self._episode_length.zero_()
        if self._curiosity is not None:
            self._curiosity.forget()
        self._logs.clear()
        self._step = 0

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Write a state of :meth:`state_dict` back."""
        self.forget_episodes()
        self._last_returns.extend(state["returns"])
        self._last_lengths.extend(state["lengths"])
        self._reward_sum.copy_(state["reward_sum"])
        self._episode_length.copy_(state["episode_length"])
        self._total_time_s = state["total_time_s"]
        if self._curiosity is not None:
            self._curiosity.load_state_dict(state)


class _Curiosity:
    """Intrinsic rewards of random network distillation, summed over episodes."""

    def __init__(self, shape: tuple[int, int], device: str):
        """Begin with no episode.

        Args:
            shape: steps of a rollout, environments.
            device: device of the rewards.
        """
        self._sum = torch.zeros(shape[1], device=device)
        self._returns = torch.zeros(shape, device=device)
        self._last: deque[float] = deque(maxlen=LAST_EPISODES)

    def add(self, step: int, rewards: torch.Tensor, done: torch.Tensor) -> None:
        """Add one step of the rollout; both tensors are of shape (num_envs,)."""
        self._sum += rewards
        self._returns[step] = self._sum
        self._sum.masked_fill_(done, 0.0)

    def finish(self, finished: torch.Tensor) -> None:
        """Take the episodes of the rollout that ended; a bool tensor of shape (steps, num_envs)."""
        self._last.extend(self._returns[: len(finished)][finished].tolist())

    def mean_return(self) -> float:
        """Mean over the last episodes; 0 before the first."""
        return statistics.fmean(self._last) if self._last else 0.0

    def forget(self) -> None:
        """Drop all episodes."""
        self._sum.zero_()
        self._last.clear()

    def state_dict(self) -> dict[str, Any]:
        """Running sums and the last episodes."""
        return {"intrinsic_returns": list(self._last), "intrinsic_sum": self._sum.cpu().clone()}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Write a state of :meth:`state_dict` back."""
        self._last.extend(state["intrinsic_returns"])
        self._sum.copy_(state["intrinsic_sum"])


def _add(writer: Any, scalars: dict[str, float], iteration: int) -> None:
    for tag, value in scalars.items():
        writer.add_scalar(tag, value, iteration)
