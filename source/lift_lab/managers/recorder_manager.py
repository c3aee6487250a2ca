"""Recording: what terms return at each stage of a step, gathered by episode and exported to dataset files."""

from __future__ import annotations

import dataclasses
import enum
import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import torch

from lift_lab.utils import ConfigBase, configclass
from lift_lab.utils.datasets import EpisodeData, HDF5DatasetFileHandler
from lift_lab.utils.errors import ConfigTypeError

from ._table import render_table
from ._term_managers import ObjectTermManager
from .manager_base import EnvIds, ManagerTermBase, as_env_id_tensor
from .manager_term_cfg import RecorderTermCfg

if TYPE_CHECKING:
    from lift_lab.envs import ManagerBasedEnv

Record = tuple[str | None, torch.Tensor | dict | None]
"""A key, nested by "/", and a tensor or dict of tensors with one row for each environment; (None, None)
records nothing."""


class DatasetExportMode(enum.IntEnum):
    """Episodes that are written, and their files."""

    EXPORT_NONE = 0
    """None."""

    EXPORT_ALL = 1
    """All, to one file."""

    EXPORT_SUCCEEDED_FAILED_IN_SEPARATE_FILES = 2
    """Succeeded ones to the file, the others to a second one whose name ends in ``_failed``."""

    EXPORT_SUCCEEDED_ONLY = 3
    """Succeeded ones, to one file."""


@configclass
class RecorderManagerBaseCfg(ConfigBase):
    """Files of recordings. Add terms as fields of a sub-class."""

    dataset_file_handler_class_type: type = HDF5DatasetFileHandler
    """Writer of the files."""

    dataset_export_dir_path: str = os.path.join("logs", "recordings")
    """Folder of the files."""

    dataset_filename: str = "dataset"
    """Name of the file, with or without its extension."""

    dataset_export_mode: DatasetExportMode = DatasetExportMode.EXPORT_ALL
    """Episodes that are written."""

    export_in_record_pre_reset: bool = True
    """Whether an episode is written when its environment resets."""

    export_in_close: bool = False
    """Whether unfinished episodes are written when the environment closes."""


class RecorderTerm(ManagerTermBase):
    """Returns what to record at the stages of a step; each method records nothing unless overridden.

    Source: Isaac Lab's ``RecorderTerm``.
    """

    def record_pre_reset(self, env_ids: Sequence[int]) -> Record:
        """Before environments reset: values of shape (len(env_ids), ...)."""
        return None, None

    def record_post_reset(self, env_ids: Sequence[int]) -> Record:
        """After environments reset: values of shape (len(env_ids), ...)."""
        return None, None

    def record_pre_step(self) -> Record:
        """After the action is processed, before it is applied: values of shape (num_envs, ...)."""
        return None, None

    def record_post_step(self) -> Record:
        """At the end of a step: values of shape (num_envs, ...)."""
        return None, None

    def record_post_physics_decimation_step(self) -> Record:
        """After each physics step: values of shape (num_envs, ...)."""
        return None, None

    def close(self, file_path: str) -> None:
        """Finish; ``file_path`` is the dataset's path as configured."""


class RecorderManager(ObjectTermManager):
    """Gathers episodes and exports them. Without terms, every method returns at once.

    An episode succeeded if the termination term named ``success`` was true at its end. Source: Isaac Lab's
    ``RecorderManager``.
    """

    term_cfg_type = RecorderTermCfg
    term_type = RecorderTerm
    unsaved_attributes: ClassVar[frozenset[str]] = frozenset({"_handlers", "_path"})
    settings = tuple(field.name for field in dataclasses.fields(RecorderManagerBaseCfg))

    def __init__(self, cfg: object, env: ManagerBasedEnv):
        """Build the terms and create the dataset files.

        Raises:
            TypeError: the config has terms but is no :class:`RecorderManagerBaseCfg`.
        """
        super().__init__(cfg, env)
        self._episodes: dict[int, EpisodeData] = {}
        self._handlers: dict[bool, Any] = {}  # by whether the episode succeeded
        self._exported: dict[bool, int] = {True: 0, False: 0}
        if not self._terms:
            return
        if not isinstance(self.cfg, RecorderManagerBaseCfg):
            raise ConfigTypeError(f"recorder terms need a RecorderManagerBaseCfg, not a '{type(self.cfg).__name__}'")
        self._path = os.path.join(self.cfg.dataset_export_dir_path, self.cfg.dataset_filename)
        mode = self.cfg.dataset_export_mode
        if mode != DatasetExportMode.EXPORT_NONE:
            self._handlers[True] = self._create_file(self._path)
        if mode == DatasetExportMode.EXPORT_ALL:
            self._handlers[False] = self._handlers[True]
        elif mode == DatasetExportMode.EXPORT_SUCCEEDED_FAILED_IN_SEPARATE_FILES:
            self._handlers[False] = self._create_file(f"{self._path.removesuffix('.hdf5')}_failed")

    def _create_file(self, path: str) -> Any:
        handler = self.cfg.dataset_file_handler_class_type()
        handler.create(path, env_name=getattr(self._env.cfg, "env_name", None))
        return handler

    def __str__(self) -> str:
        return (
            f"<RecorderManager> contains {len(self._terms)} active terms.\n"
            f"{render_table('Active Recorder Terms', ['Index', 'Name'], list(enumerate(self._terms)))}"
        )

    @property
    def exported_successful_episode_count(self) -> int:
        """Succeeded episodes that were concluded, written or not."""
        return self._exported[True]

    @property
    def exported_failed_episode_count(self) -> int:
        """Other episodes that were concluded, written or not."""
        return self._exported[False]

    def get_episode(self, env_id: int) -> EpisodeData:
        """The episode that an environment is recording."""
        return self._episodes.get(env_id, EpisodeData())

    def reset(self, env_ids: EnvIds = None) -> dict[str, Any]:
        """Drop what some environments have recorded; logs nothing."""
        if self._terms:
            ids = self._list(env_ids)
            for term in self._terms.values():
                term.reset(env_ids=ids)
            self._forget(ids)
        return {}

    def record_pre_step(self) -> None:
        """Call the terms after the action is processed."""
        for term in self._terms.values():
            self.add_to_episodes(*term.record_pre_step())

    def record_post_step(self) -> None:
        """Call the terms at the end of a step."""
        for term in self._terms.values():
            self.add_to_episodes(*term.record_post_step())

    def record_post_physics_decimation_step(self) -> None:
        """Call the terms after a physics step."""
        for term in self._terms.values():
            self.add_to_episodes(*term.record_post_physics_decimation_step())

    def record_pre_reset(self, env_ids: EnvIds = None, force_export_or_skip: bool | None = None) -> None:
        """Call the terms, note which episodes succeeded, and export them.

        Args:
            env_ids: The environments about to reset.
            force_export_or_skip: Whether to export; None leaves it to the config.
        """
        if not self._terms:
            return
        ids = self._list(env_ids)
        for term in self._terms.values():
            self.add_to_episodes(*term.record_pre_reset(ids), env_ids=ids)
        terminations = getattr(self._env, "termination_manager", None)
        if terminations is not None and "success" in terminations.active_terms:
            self.set_success_to_episodes(ids, terminations.get_term("success")[ids])
        else:
            self.set_success_to_episodes(ids, torch.zeros(len(ids), dtype=torch.bool))
        export = self.cfg.export_in_record_pre_reset if force_export_or_skip is None else force_export_or_skip
        if export:
            self.export_episodes(ids)

    def record_post_reset(self, env_ids: EnvIds = None) -> None:
        """Call the terms after environments reset."""
        if not self._terms:
            return
        ids = self._list(env_ids)
        for term in self._terms.values():
            self.add_to_episodes(*term.record_post_reset(ids), env_ids=ids)

    def add_to_episodes(self, key: str | None, value: torch.Tensor | dict | None, env_ids: EnvIds = None) -> None:
        """Append a value to the episodes of some environments.

        Args:
            key: Where in the episode, nested by "/"; None adds nothing.
            value: A tensor with one row for each environment, or a dict of them.
            env_ids: The environments.
        """
        if not self._terms or key is None or value is None:
            return
        ids = self._list(env_ids)
        if isinstance(value, dict):
            for name, part in value.items():
                self.add_to_episodes(f"{key}/{name}", part, ids)
            return
        for env_id, row in zip(ids, value):  # noqa: B905 - a term may return a row for every environment
            self._open_episode(env_id).add(key, row)

    def set_success_to_episodes(self, env_ids: EnvIds, success_values: torch.Tensor) -> None:
        """Note whether the episodes of some environments succeeded.

        Args:
            env_ids: The environments.
            success_values: Shape is (len(env_ids),) or (len(env_ids), 1).
        """
        if self._terms:
            for env_id, success in zip(self._list(env_ids), success_values.flatten().tolist(), strict=True):
                self._open_episode(env_id).success = bool(success)

    def export_episodes(self, env_ids: EnvIds = None, demo_ids: Iterable[int] | None = None) -> None:
        """Conclude the episodes of some environments, write them as the mode says, and start empty ones.

        Args:
            env_ids: The environments.
            demo_ids: Number of each episode in the file, in place of the next free one.

        Raises:
            ValueError: ``demo_ids`` repeat, or are not one for each environment.
        """
        if not self._terms:
            return
        ids = self._list(env_ids)
        numbers: list[int | None] = [None] * len(ids) if demo_ids is None else [int(number) for number in demo_ids]
        if demo_ids is not None and (len(numbers) != len(ids) or len(set(numbers)) != len(numbers)):
            raise ValueError(f"demo_ids must be {len(ids)} different numbers, one for each environment, not {numbers}")
        written = set()
        for env_id, number in zip(ids, numbers, strict=True):
            episode = self.get_episode(env_id)
            if episode.is_empty():
                continue
            episode.pre_export()
            succeeded = bool(episode.success)
            self._exported[succeeded] += 1
            handler = self._handlers.get(succeeded)
            if handler is not None:
                if handler not in written:
                    handler.add_env_args(self.get_ep_meta())
                handler.write_episode(episode, number)
                written.add(handler)
        self._forget(ids)
        for handler in written:
            handler.flush()

    def get_ep_meta(self) -> dict:
        """Settings stored in the files: what ``env.cfg.get_ep_meta()`` returns, else those of the
        simulation."""
        cfg = self._env.cfg
        if hasattr(cfg, "get_ep_meta"):
            return cfg.get_ep_meta()
        return {
            "sim_args": {
                "dt": cfg.sim.dt,
                "decimation": cfg.decimation,
                "render_interval": cfg.sim.render_interval,
                "num_envs": cfg.scene.num_envs,
            }
        }

    def close(self) -> None:
        """Export unfinished episodes if configured, and close the files. A second call does nothing."""
        if self._handlers and self.cfg.export_in_close:
            self.export_episodes()
        for handler in set(self._handlers.values()):
            handler.close()
        self._handlers = {}
        for term in self._terms.values():
            term.close(self._path)

    def _open_episode(self, env_id: int) -> EpisodeData:
        if env_id not in self._episodes:
            self._episodes[env_id] = EpisodeData()
            self._episodes[env_id].env_id = env_id
        return self._episodes[env_id]

    def _list(self, env_ids: EnvIds) -> list[int]:
        return env_ids if isinstance(env_ids, list) else as_env_id_tensor(env_ids, self.num_envs, "cpu").tolist()

    def _forget(self, env_ids: list[int]) -> None:
        for env_id in env_ids:
            self._episodes.pop(env_id, None)
