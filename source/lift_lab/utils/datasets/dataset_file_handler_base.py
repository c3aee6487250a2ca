"""Base class of files of episodes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable

import torch

from .episode_data import EpisodeData


class DatasetFileHandlerBase(ABC):
    """A file of episodes."""

    @abstractmethod
    def open(self, file_path: str, mode: str = "r") -> None:
        """Open an existing file."""

    @abstractmethod
    def create(self, file_path: str, env_name: str | None = None) -> None:
        """Create a file, replacing an existing one."""

    @abstractmethod
    def get_env_name(self) -> str | None:
        """Name of the environment that the episodes come from."""

    @abstractmethod
    def get_episode_names(self) -> Iterable[str]:
        """Names of the episodes."""

    @abstractmethod
    def get_num_episodes(self) -> int:
        """Number of episodes."""

    @abstractmethod
    def write_episode(self, episode: EpisodeData, demo_id: int | None = None) -> None:
        """Add an episode."""

    @abstractmethod
    def load_episode(self, episode_name: str, device: torch.device | str = "cpu") -> EpisodeData | None:
        """Read an episode; None if there is none of that name."""

    @abstractmethod
    def flush(self) -> None:
        """Write everything to the disk."""

    @abstractmethod
    def close(self) -> None:
        """Close the file."""
