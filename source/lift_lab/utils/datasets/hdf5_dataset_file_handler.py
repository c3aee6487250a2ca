"""Files of episodes in HDF5, in the layout of robomimic and Isaac Lab.

Group ``data`` has the attributes ``total`` (number of steps) and ``env_args`` (JSON). It holds a group ``demo_N`` per
episode with the attributes ``num_samples``, ``seed`` and ``success`` and the episode's data sets.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch

from ..errors import ConfigError, FileError, MissingPackageError
from .dataset_file_handler_base import DatasetFileHandlerBase
from .episode_data import EpisodeData

_ENV_TYPE_GYM = 2  # robomimic's number for gym environments


class HDF5DatasetFileHandler(DatasetFileHandlerBase):
    """A file of episodes in HDF5. Needs the package h5py."""

    def __init__(self) -> None:
        self._h5py = _import_h5py()
        self._path = ""
        self._file: Any = None
        self._episodes: Any = None
        self._demo_count = 0
        self._env_args: dict[str, Any] = {}

    def open(self, file_path: str, mode: str = "r") -> None:
        """Open an existing file.

        Raises:
            FileError: no such file, or it is damaged or no file of episodes.
            RuntimeError: a file is open already.
        """
        self._check_closed()
        if not Path(file_path).is_file():
            raise FileError(f"no dataset file '{file_path}'")
        self._path = str(file_path)
        with self._reading():
            file = self._h5py.File(file_path, mode)
            try:
                episodes = file["data"]
                self._demo_count = len(episodes)
                self._env_args = dict(json.loads(episodes.attrs.get("env_args", "{}")))
            except BaseException:
                file.close()
                raise
        self._file, self._episodes = file, episodes

    def create(self, file_path: str, env_name: str | None = None) -> None:
        """Create a file, replacing an existing one; ``.hdf5`` is appended where it is missing.

        Raises:
            RuntimeError: a file is open already.
        """
        self._check_closed()
        path = Path(file_path if str(file_path).endswith(".hdf5") else f"{file_path}.hdf5")
        path.parent.mkdir(parents=True, exist_ok=True)
        self._path = str(path)
        self._file = self._h5py.File(path, "w")
        self._episodes = self._file.create_group("data")
        self._episodes.attrs["total"] = 0
        self._demo_count = 0
        self._env_args = {}
        self.add_env_args({"env_name": env_name or "", "type": _ENV_TYPE_GYM})

    def __del__(self) -> None:
        if getattr(self, "_file", None) is not None:
            self.close()

    def add_env_args(self, env_args: dict) -> None:
        """Store arguments that describe the environment, beside those stored before."""
        episodes = self._open_episodes()
        self._env_args.update(env_args)
        episodes.attrs["env_args"] = json.dumps(self._env_args)

    def set_env_name(self, env_name: str) -> None:
        """Store the environment's name."""
        self.add_env_args({"env_name": env_name})

    def get_env_name(self) -> str | None:
        """Name of the environment; None if it was not stored."""
        return json.loads(self._open_episodes().attrs["env_args"]).get("env_name")

    def get_episode_names(self) -> Iterable[str]:
        """Names of the episodes.

        Raises:
            FileError: the file is damaged.
        """
        episodes = self._open_episodes()
        with self._reading():
            return list(episodes)

    def get_num_episodes(self) -> int:
        """Number of episodes."""
        return self._demo_count

    @property
    def demo_count(self) -> int:
        """Number of episodes."""
        return self._demo_count

    def load_episode(self, episode_name: str, device: torch.device | str = "cpu") -> EpisodeData | None:
        """Read an episode; None if there is none of that name.

        Raises:
            FileError: the file is damaged.
        """
        episodes = self._open_episodes()
        with self._reading():
            if episode_name not in episodes:
                return None
            group = episodes[episode_name]
            episode = EpisodeData()
            episode.data = self._read(group, device)
            episode.seed = group.attrs.get("seed")
            episode.success = group.attrs.get("success")
            episode.env_id = self.get_env_name()
            return episode

    def write_episode(self, episode: EpisodeData, demo_id: int | None = None) -> None:
        """Add an episode (an empty one is skipped).

        Args:
            episode: the episode, with stacked data (:meth:`EpisodeData.pre_export`).
            demo_id: number in its name. None numbers in order.

        Raises:
            ConfigError: there is an episode of that number.
        """
        episodes = self._open_episodes()
        if episode.is_empty():
            return
        name = f"demo_{self._demo_count if demo_id is None else demo_id}"
        if name in episodes:
            raise ConfigError(f"the dataset has an episode '{name}' already")
        group = episodes.create_group(name)
        num_samples = len(episode.data.get("actions", ()))
        group.attrs["num_samples"] = num_samples
        for key, value in (("seed", episode.seed), ("success", episode.success)):
            if value is not None:
                group.attrs[key] = value
        for key, value in episode.data.items():
            self._write(group, key, value)
        episodes.attrs["total"] += num_samples
        if demo_id is None:
            self._demo_count += 1

    def flush(self) -> None:
        """Write everything to the disk."""
        self._open_episodes()
        self._file.flush()

    def close(self) -> None:
        """Close the file, if one is open."""
        if self._file is not None:
            self._file.close()
            self._file = self._episodes = None

    @contextlib.contextmanager
    def _reading(self) -> Iterator[None]:
        """Turn what h5py raises for a damaged file into one line."""
        try:
            yield
        except Exception as error:  # h5py has no class of its own for it
            reason = next(iter(str(error).strip("'\"").splitlines()), type(error).__name__)
            raise FileError(f"cannot read '{self._path}': damaged, or no file of episodes ({reason})") from error

    def _read(self, group: Any, device: torch.device | str) -> dict[str, Any]:
        return {
            key: self._read(entry, device)
            if isinstance(entry, self._h5py.Group)
            else torch.as_tensor(np.asarray(entry), device=device)
            for key, entry in group.items()
        }

    def _write(self, group: Any, key: str, value: Any) -> None:
        if isinstance(value, dict):
            below = group.create_group(key)
            for sub_key, sub_value in value.items():
                self._write(below, sub_key, sub_value)
        else:
            group.create_dataset(key, data=value.cpu().numpy(), compression="gzip")

    def _check_closed(self) -> None:
        if self._file is not None:
            raise RuntimeError("HDF5DatasetFileHandler: a file is open already; close it first")

    def _open_episodes(self) -> Any:
        if self._episodes is None:
            raise RuntimeError("HDF5DatasetFileHandler: no file is open; call open() or create() first")
        return self._episodes


def _import_h5py() -> Any:
    try:
        import h5py
    except ImportError as error:
        raise MissingPackageError("HDF5 datasets need the package h5py; install it with 'pip install h5py'") from error
    return h5py
