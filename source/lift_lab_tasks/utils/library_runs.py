"""Checkpoints of the learning libraries whose configuration is a dictionary (skrl, sb3)."""

from __future__ import annotations

import re
from pathlib import Path

from lift_lab.utils.errors import FileError

from .parse_cfg import get_checkpoint_path


def task_folder(task: str) -> str:
    """Name of the folder of a task's runs: its id; a task and its ``-Play`` share one."""
    return task.rpartition(":")[2].removesuffix("-Play")


def model_file(path: str) -> Path:
    """An existing checkpoint's path.

    Raises:
        FileError: there is no such file.
    """
    if not Path(path).is_file():
        raise FileError(f"no checkpoint '{path}'")
    return Path(path).absolute()


def find_model(parent: Path, wanted: str | None, run: str | None, *patterns: str, folder: str = "") -> Path:
    """The checkpoint that a user means.

    Args:
        parent: folder of the experiment's runs.
        wanted: path of a file; a regular expression of file names; None for what matches ``patterns``.
        run: regular expression of the run's folder name; None for all.
        *patterns: regular expressions of file names; of the newest run that has any, the first that it has is taken.
        folder: folder between a run and its checkpoints.

    Raises:
        FileError: there is none.
    """
    if wanted is not None:
        if Path(wanted).is_file() or Path(wanted).parent != Path("."):
            return model_file(wanted)
        patterns = (wanted,)
    others = [folder] if folder else None
    any_of_them = "|".join(f"(?:{pattern})" for pattern in patterns)
    newest = Path(get_checkpoint_path(parent.absolute(), run or ".*", any_of_them, others)).parent
    newest = newest.parent if folder else newest
    for pattern in patterns[:-1]:
        try:
            return Path(get_checkpoint_path(newest.parent, re.escape(newest.name), pattern, others))
        except FileError:
            continue
    return Path(get_checkpoint_path(newest.parent, re.escape(newest.name), patterns[-1], others))
