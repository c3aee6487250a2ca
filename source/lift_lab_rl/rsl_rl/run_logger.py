"""Curves of a training run: rsl_rl's logger without its console prints, its git copies and its waiting.

Everything that happens in a rollout is kept on the device and read once at its end, so that no step waits for a
transfer. Tags are rsl_rl's; ``Reward / ...`` and ``Episode / ...`` are skrl's, which the study's figures use.
"""

from __future__ import annotations

import statistics
from pathlib import Path
from typing import Any

import torch
from rsl_rl.utils.log_writer import LogWriter
from rsl_rl.utils.logger import Logger

from .curve_files import CurveWriter
from .progress import IterationReport


class RunLogger(Logger):
    """Collects what happens in rollouts and writes it once an iteration."""

    def __init__(self, *args: Any, **kwargs: Any):
        """As rsl_rl's logger."""
        super().__init__(*args, **kwargs)
        steps = self.cfg["num_steps_per_env"]
        shape = (steps, self.num_envs)
        self._rewards = torch.zeros(shape, device=self.device)
        self._returns = torch.zeros(shape, device=self.device)
        self._lengths = torch.zeros(shape, device=self.device)
        self._dones = torch.zeros(shape, dtype=torch.bool, device=self.device)
        self._step = 0
        self._last_log: dict[str, Any] | None = None

    def init_logging_writer(self) -> None:
        """Open what curves go to: an event file that outlives a full disk, or a service."""
        if self.log_dir is None or self.disable_logs or self.cfg.get("logger", "tensorboard") != "tensorboard":
            super().init_logging_writer()
        else:
            self.writer = CurveWriter(self.log_dir)  # type: ignore[assignment]

    def _store_code_state(self) -> list[str]:
        return []

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
            extras: with the environment's ``log``, and in ``log_counts`` how many episodes an entry is the mean of, if
                not of all that ended.
            intrinsic_rewards: shape (num_envs,).
        """
        step, done = self._step, dones > 0
        # An environment keeps its last log until the next reset: each is counted once.
        log = extras.get("log")
        if log and log is not self._last_log:
            self.ep_extras.append((dict(log), step, extras.get("log_counts", {})))
            self._last_log = log
        self._rewards[step] = rewards
        total = rewards if intrinsic_rewards is None else rewards + intrinsic_rewards
        self.cur_reward_sum += total
        self.cur_episode_length += 1
        self._returns[step] = self.cur_reward_sum
        self._lengths[step] = self.cur_episode_length
        self._dones[step] = done
        self.cur_reward_sum.masked_fill_(done, 0.0)
        self.cur_episode_length.masked_fill_(done, 0.0)
        self._step = step + 1

    def drop_rollout(self) -> None:
        """Forget the running rollout."""
        self.ep_extras.clear()
        self._step = 0

    def episode_logs(self) -> dict[str, float]:
        """The environment's logs of this rollout, each averaged over its episodes that ended.

        What an environment logs without the end of an episode, as of the reset when it is made, is of no episode.
        """
        if not self.ep_extras:
            return {}
        ended = self._dones.sum(1).tolist()
        logs = [(log, ended[step], counts) for log, step, counts in self.ep_extras if ended[step]]
        means = {}
        for key in dict.fromkeys(key for log, *_ in logs for key in log):
            pairs = [(log[key], counts.get(key, everyone)) for log, everyone, counts in logs if key in log]
            values = [float(v.float().mean()) if isinstance(v, torch.Tensor) else float(v) for v, _ in pairs]
            weights = [weight for _, weight in pairs]
            means[key] = sum(v * w for v, w in zip(values, weights, strict=True)) / sum(weights)
        return means

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
        self.tot_timesteps = report.total_steps
        self.tot_time += report.collect_s + report.learn_s
        used = slice(0, self._step)
        finished = self._dones[used]
        self.rewbuffer.extend(self._returns[used][finished].tolist())
        self.lenbuffer.extend(self._lengths[used][finished].tolist())
        report.terms = self.episode_logs()
        if self.rewbuffer:
            report.mean_reward = statistics.fmean(self.rewbuffer)
            report.mean_length = statistics.fmean(self.lenbuffer)
        if self.writer is not None:
            for tag, value in self._scalars(report, losses, rnd_weight).items():
                self.writer.add_scalar(tag, value, report.iteration)
            if isinstance(self.writer, LogWriter):
                for video in sorted(Path(str(self.log_dir)).glob("videos/*/[!.]*.mp4")):
                    self.writer.save_video(video, report.iteration)
            # A kill loses the running iteration at most.
            self.writer.flush()  # type: ignore[union-attr]
        self.drop_rollout()

    def _scalars(self, report: IterationReport, losses: dict[str, float], rnd_weight: float | None) -> dict[str, float]:
        tags = {(key if "/" in key else f"Episode/{key}"): value for key, value in report.terms.items()}
        tags |= {f"Loss/{key}": value for key, value in losses.items()}
        if "entropy" in losses:
            tags["Loss / Entropy loss"] = -report.entropy_coef * losses["entropy"]
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
        for kind, value in zip(("mean", "max", "min"), spread, strict=True):
            tags[f"Reward / Instantaneous reward ({kind})"] = value
        if report.mean_reward is not None and report.mean_length is not None:
            tags["Train/mean_reward"] = report.mean_reward
            tags["Train/mean_episode_length"] = report.mean_length
            tags["Reward / Total reward (mean)"] = report.mean_reward
            tags["Reward / Total reward (max)"] = max(self.rewbuffer)
            tags["Reward / Total reward (min)"] = min(self.rewbuffer)
            tags["Episode / Total timesteps (mean)"] = report.mean_length
            tags["Episode / Total timesteps (max)"] = max(self.lenbuffer)
            tags["Episode / Total timesteps (min)"] = min(self.lenbuffer)
        return tags

    # -- continuing a run

    def state_dict(self) -> dict[str, Any]:
        """Running sums and the last episodes, as tensors and plain values."""
        return {
            "returns": list(self.rewbuffer),
            "lengths": list(self.lenbuffer),
            "reward_sum": self.cur_reward_sum.cpu().clone(),
            "episode_length": self.cur_episode_length.cpu().clone(),
            "total_time_s": self.tot_time,
        }

    def forget_episodes(self) -> None:
        """Drop the last episodes, the running ones and the steps of a rollout that was broken off."""
        self.rewbuffer.clear()
        self.lenbuffer.clear()
        self.cur_reward_sum.zero_()
        self.cur_episode_length.zero_()
        self.ep_extras.clear()
        self._step = 0

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Write a state of :meth:`state_dict` back."""
        self.forget_episodes()
        self.rewbuffer.extend(state["returns"])
        self.lenbuffer.extend(state["lengths"])
        self.cur_reward_sum.copy_(state["reward_sum"])
        self.cur_episode_length.copy_(state["episode_length"])
        self.tot_time = state["total_time_s"]
