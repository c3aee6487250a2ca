"""Policies of the viewer: zero actions, random actions, or the checkpoints of a run."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

import torch

from lift_lab.utils.errors import ConfigError, FileError, LiftLabError, suggest


class ViewedPolicy(ABC):
    """A policy that may have several versions to choose from."""

    current: str = ""
    """Name of the version that acts."""

    @abstractmethod
    def act(self, obs: Any) -> torch.Tensor:
        """Actions of shape (num_envs, num_actions) for observations."""

    def reset(self, dones: torch.Tensor) -> None:  # noqa: B027 - most policies have no memory
        """Forget the past of environments whose episode ended, shape (num_envs,)."""

    def choices(self) -> list[str]:
        """Versions that there are now, oldest first."""
        return [self.current]

    def choose(self, name: str) -> None:  # noqa: B027 - there is nothing to choose without checkpoints
        """Let another version act.

        Raises:
            LiftLabError: it cannot be loaded; the previous policy continues.
        """

    def warning(self) -> str | None:
        """One line about something that is wrong, or None."""
        return None


class ZeroPolicy(ViewedPolicy):
    """Acts with zeros."""

    current = "zero"

    def __init__(self, env: Any):
        self._zeros = torch.zeros(env.num_envs, env.num_actions, device=env.device)

    def act(self, obs: Any) -> torch.Tensor:
        return self._zeros


class RandomPolicy(ViewedPolicy):
    """Acts with numbers drawn uniformly from [-1, 1]."""

    current = "random"

    def __init__(self, env: Any):
        self._shape = (env.num_envs, env.num_actions)
        self._device = env.device

    def act(self, obs: Any) -> torch.Tensor:
        return torch.empty(self._shape, device=self._device).uniform_(-1.0, 1.0)


class CheckpointPolicy(ViewedPolicy):
    """The checkpoints in one folder, which may grow, shrink or go away meanwhile."""

    def __init__(self, runner: Any, checkpoint: Path, device: str):
        """Load a checkpoint.

        Args:
            runner: a :class:`~lift_lab_rl.rsl_rl.LiftLabRunner` of the environment.
            checkpoint: the file that acts first.
            device: device of the policy.

        Raises:
            FileError: the file does not exist or cannot be read.
            ConfigError: it is of other networks.
        """
        self._runner = runner
        self._device = device
        self._folder = checkpoint.parent
        self._load(checkpoint.name)

    def act(self, obs: Any) -> torch.Tensor:
        return self._policy(obs)

    def reset(self, dones: torch.Tensor) -> None:
        self._policy.reset(dones)

    def choices(self) -> list[str]:
        found = {path.name for path in self._folder.glob("model_*.pt")} if self._folder.is_dir() else set()
        return sorted(found | {self.current}, key=_by_iteration)

    def choose(self, name: str) -> None:
        before, choices = self.current, self.choices()
        if name not in choices:  # a page may send any text, also a path to another folder
            raise FileError(f"no file '{name}' in '{self._folder}'; {suggest(name, choices)}")
        try:
            self._load(name)
        except ConfigError as error:
            self._restore(before, error)
            raise

    def newest(self) -> str:
        """The checkpoint with the most iterations; ``model_best.pt`` counts only where there is no other."""
        numbered = [name for name in self.choices() if _by_iteration(name)[0] >= 0]
        return numbered[-1] if numbered else self.current

    def warning(self) -> str | None:
        if not self._folder.is_dir():
            return f"the run's folder '{self._folder}' is gone: '{self.current}' goes on from memory"
        return None

    def _load(self, name: str) -> None:
        self._runner.load_policy(str(self._folder / name))
        self._policy = self._runner.get_inference_policy(device=self._device)
        self.current = name

    def _restore(self, name: str, reason: ConfigError) -> None:
        """A file of other networks may have overwritten a part of these."""
        try:
            self._load(name)
        except FileError as error:
            raise LiftLabError(f"{reason}; and '{name}', which acted before, is gone") from error


def _by_iteration(name: str) -> tuple[int, str]:
    found = re.fullmatch(r"model_(\d+)\.pt", name)
    return (int(found[1]) if found else -1, name)
