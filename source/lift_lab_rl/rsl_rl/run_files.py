"""The files that a run is continued from: ``model_N.pt`` after N iterations, and each process's state beside it."""

from __future__ import annotations

import contextlib
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import Any

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl.distributed import Place
from lift_lab_rl.run_params import read_params

from .checkpoint_file import read_checkpoint
from .evaluation_cfg import RslRlEvaluationCfg, criteria


def state_name(place: Place, iteration: int | str) -> str:
    """File name of a process's state after an iteration."""
    return f"resume_state_{iteration}.pt" if place.is_main else f"rank{place.rank}_state_{iteration}.pt"


def remove_old_states(folder: Path, place: Place, keep: int) -> None:
    """Remove all but the newest ``keep`` states of a process."""
    states = sorted(folder.glob(state_name(place, "*")), key=_number_of)
    for old in states[:-keep]:
        with contextlib.suppress(OSError):  # another process was faster, or the folder is read-only now
            old.unlink()


def checkpoint_iteration(path: str | Path) -> int:
    """Iterations that the checkpoint at ``path`` had finished.

    Raises:
        FileError: there is no such file, or it is damaged.
        ConfigError: it is no checkpoint, or holds a number that is not finite.
    """
    return read_checkpoint(path)["iter"]


def solved_by(path: str | Path) -> dict[str, Any] | None:
    """Return the criteria by which the task of a checkpoint is solved; None if it is not.

    Returns:
        :meth:`~lift_lab_rl.rsl_rl.training_evaluation.TrainingEvaluation.criteria`.

    Raises:
        FileError: there is no such file, or it is damaged.
        ConfigError: it is no checkpoint, or holds a number that is not finite.
    """
    return (read_checkpoint(path).get("infos") or {}).get("solved")


def is_solved(path: str | Path, evaluation: RslRlEvaluationCfg | None) -> bool:
    """Return whether a checkpoint is of a training that these evaluations would have ended: the task is solved.

    Raises:
        FileError: there is no such file, or it is damaged.
        ConfigError: it is no checkpoint, or holds a number that is not finite.
    """
    return evaluation is not None and solved_by(path) == criteria(evaluation.to_dict())


class Readable:
    """Check of checkpoints for damage, with one message for each run that has a damaged one."""

    def __init__(self, say: Callable[[str], None]):
        """Have said nothing yet.

        Args:
            say: takes the line.
        """
        self._say = say
        self._named: set[Path] = set()

    def run(self, folder: Path) -> bool:
        """Whether the folder of a run names its task."""
        try:
            read_params(folder, "run")
        except FileError as error:
            return self._skip(folder, error)
        return True

    def checkpoint(self, path: Path) -> bool:
        """Whether a checkpoint can be read and is whole."""
        try:
            read_checkpoint(path)
        except (FileError, ConfigError) as error:
            return self._skip(path.parent, error)
        return True

    def _skip(self, folder: Path, error: Exception) -> bool:
        if folder not in self._named:
            self._say(f"warning: skipped, in run '{folder.name}': {error}")
        self._named.add(folder)
        return False


def trained_with(path: str | Path) -> str:
    """Task and overrides of the run that a checkpoint is of, as on a command line; empty where its folder says none."""
    run = read_params(Path(path).parent, "run")
    return shlex.join(["--task", str(run.get("task")), *map(str, run.get("overrides") or ())]) if run else ""


def _number_of(path: Path) -> int:
    digits = path.stem.rpartition("_")[2]
    return int(digits) if digits.isdigit() else -1
