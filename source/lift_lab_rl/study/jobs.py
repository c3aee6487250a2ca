"""Jobs of a study: variants of a task, each trained with several seeds, and the state of each job."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lift_lab.utils.errors import ConfigError, FileError, suggest
from lift_lab_rl.scalar_names import renamed_evaluation

_TIME = r"\d{4}-\d\d-\d\d_\d\d-\d\d-\d\d_"
"""Start of the name of a run's folder."""


@dataclass(frozen=True)
class Variant:
    """One way to train."""

    label: str
    task: str
    overrides: tuple[str, ...] = ()
    start: tuple[str, int] | None = None
    """Label and iteration of the training from whose checkpoint this one continues, seed by seed; None starts from the
    beginning."""

    @classmethod
    def parse(cls, text: str) -> Variant:
        """``"[LABEL=]TASK [from=LABEL@ITERATION] [override ...]"``.

        For example ``"linear=Lift-Cube-Franka-CL env/curriculum=linear"``, or, for two tasks that are the same until
        iteration 700, ``"Lift-Cube-Franka from=Lift-Cube-Franka-CL@700"``.

        Raises:
            ConfigError: no task, a label that cannot be part of a folder's name, or a start that names no iteration.
        """
        try:
            words = shlex.split(text)
        except ValueError as error:
            raise ConfigError(f"the task '{text}' cannot be read: {str(error).lower()}") from error
        starts = [word for word in words[1:] if word.startswith("from=")]
        words = [word for word in words if word not in starts]
        label, equals, task = words[0].partition("=") if words else ("", "", "")
        if not equals:
            task = label
        if not task or not re.fullmatch(r"[\w.:+-]+", label):
            raise ConfigError(
                f"'{text}': expected TASK, or 'LABEL=TASK override ...' with a label of letters and digits"
            )
        start = None
        if starts:
            origin, _, iteration = starts[-1].removeprefix("from=").rpartition("@")
            if len(starts) > 1 or not origin or not iteration.isdigit():
                raise ConfigError(f"'{text}': expected one from=LABEL@ITERATION, got '{' '.join(starts)}'")
            start = (origin.replace(":", "-"), int(iteration))
        return cls(label.replace(":", "-"), task, tuple(words[1:]), start)

    @property
    def settings(self) -> list[str]:
        """Settings that decide its trainings, as words."""
        start = [] if self.start is None else ["from={}@{}".format(*self.start)]
        return [self.task, *start, *self.overrides]


@dataclass
class Job:
    """One training of a study, with its evaluations."""

    variant: Variant
    seed: int
    record: dict[str, Any] = field(default_factory=dict)
    """Its entry in the results."""

    @property
    def name(self) -> str:
        """The run's name: reports read label and seed from it."""
        return f"{self.variant.label}-s{self.seed}"

    @property
    def origin(self) -> str | None:
        """Name of the run from which it continues."""
        return None if self.variant.start is None else f"{self.variant.start[0]}-s{self.seed}"


def make_jobs(variants: Sequence[Variant], seeds: Sequence[int]) -> list[Job]:
    """All seeds of all variants, seed by seed, so that an early look compares variants.

    Raises:
        ConfigError: a label or a seed is given twice.
    """
    for what, names in (("label", [variant.label for variant in variants]), ("seed", [str(seed) for seed in seeds])):
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ConfigError(f"the {what} '{twice}' is given twice")
    return [Job(variant, seed) for seed in seeds for variant in variants]


def in_rounds(jobs: Sequence[Job], trained: Sequence[str] = ()) -> list[list[Job]]:
    """Return the jobs in rounds: each comes after the job from whose checkpoint it continues.

    Args:
        jobs: jobs to do.
        trained: labels of earlier trainings from which jobs may continue.

    Raises:
        ConfigError: a start names no label, or starts go in a circle.
    """
    known = {job.variant.label for job in jobs} | set(trained)
    for variant in (job.variant for job in jobs):
        if variant.start is not None and variant.start[0] not in known:
            others = sorted(known - {variant.label})
            raise ConfigError(
                f"'{variant.label}' cannot start from '{variant.start[0]}': {suggest(variant.start[0], others)}"
            )
    rounds, left = [], list(jobs)
    while left:
        waiting = {job.name for job in left}
        now = [job for job in left if job.origin not in waiting]
        if not now:
            raise ConfigError(f"'{left[0].variant.label}' cannot start from itself: the starts go in a circle")
        rounds.append(now)
        left = [job for job in left if job.origin in waiting]
    return rounds


def check_start(variant: Variant, iterations: int, save_interval: int, origin_iterations: int) -> None:
    """Check that a variant's start will be saved.

    Args:
        variant: starts from another.
        iterations: how long it is to be trained, those of its start included.
        save_interval: iterations between two checkpoints of the other.
        origin_iterations: how long the other is trained.

    Raises:
        ConfigError: there will be no such checkpoint, or it leaves nothing to train.
    """
    assert variant.start is not None
    origin, start = variant.start
    if start >= iterations:
        raise ConfigError(f"'{variant.label}' starts from iteration {start}, but is trained to {iterations} only")
    if start < 1 or (start != origin_iterations and (start % save_interval or start > origin_iterations)):
        raise ConfigError(
            f"'{variant.label}' cannot start from '{origin}@{start}': '{origin}' saves every {save_interval} "
            f"iterations up to {origin_iterations}"
        )


def checkpoint_at(folder: Path, run_name: str, iteration: int) -> Path:
    """A run's checkpoint of an iteration; of its newest piece that has it.

    Raises:
        FileError: there is none; names those that there are.
    """
    found = _checkpoints(folder, run_name)
    if iteration not in found:
        have = ", ".join(map(str, found)) or "none"
        raise FileError(f"'{run_name}' has no checkpoint of iteration {iteration}; it has {have}")
    return found[iteration]


def newest_checkpoint(
    folder: Path, run_name: str, accept: Callable[[Path], bool] = lambda _: True
) -> tuple[Path, int] | None:
    """The checkpoint with most iterations among a run's pieces, and its iterations; None without one.

    Args:
        folder: the study's.
        run_name: name of the run.
        accept: tells whether a file may be taken; if not, the one before is looked at.
    """
    found = _checkpoints(folder, run_name)
    return next(((found[n], n) for n in sorted(found, reverse=True) if accept(found[n])), None)


def best_checkpoint(folder: Path, run_name: str, accept: Callable[[Path], bool] = lambda _: True) -> Path | None:
    """A run's ``model_best.pt``, of its newest piece that has one; None without one.

    Args:
        folder: the study's.
        run_name: name of the run.
        accept: tells whether a file may be taken; if not, the one before is looked at.
    """
    found = [piece / "model_best.pt" for piece in _pieces(folder, run_name) if (piece / "model_best.pt").is_file()]
    return next((path for path in reversed(found) if accept(path)), None)


def _pieces(folder: Path, run_name: str) -> list[Path]:
    """Folders of a run, the oldest first."""
    places = sorted(folder.iterdir()) if folder.is_dir() else []
    return [place for place in places if re.fullmatch(rf"{_TIME}{re.escape(run_name)}(-\d+)?", place.name)]


def _checkpoints(folder: Path, run_name: str) -> dict[int, Path]:
    """A run's checkpoints by their iterations, which ascend; of its newest piece where several have one."""
    found = []
    for piece in _pieces(folder, run_name):
        for path in piece.glob("model_*.pt"):
            digits = path.stem.removeprefix("model_")
            if digits.isdigit():
                found.append((int(digits), piece.name, path))
    return {iterations: path for iterations, _, path in sorted(found)}


def read_evaluation(path: Path, checkpoint: Path, episodes: int, seed: int) -> dict[str, Any] | None:
    """An evaluation that was done before; None if there is none of this checkpoint, length and seed."""
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:  # cut off: it is done again
        return None
    wanted = {"checkpoint": str(checkpoint), "episodes": episodes, "seed": seed}
    if not isinstance(content, dict) or not wanted.items() <= content.items():
        return None
    return renamed_evaluation(content)


def check_settings(old: dict[str, Any], new: dict[str, Any], path: Path) -> None:
    """Refuse to mix trainings of other settings into a study.

    Args:
        old: settings in the results file.
        new: settings now. ``variants`` may grow, but none may change.
        path: the results file.

    Raises:
        ConfigError: they differ; names the first that does.
    """
    for key, value in new.items():
        if key == "variants":
            changed = [label for label in value if label in old.get(key, {}) and old[key][label] != value[label]]
            if changed:
                raise ConfigError(f"'{path}' has other settings for '{changed[0]}': take another --name or label")
        elif key in old and old[key] != value:
            raise ConfigError(f"'{path}' was made with {key} {old[key]}, not {value}: take another --name")
