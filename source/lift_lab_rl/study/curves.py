"""Curves of training runs, read from TensorBoard's event files: pieces of a continued run joined, seeds grouped."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl.run_params import read_params
from lift_lab_rl.scalar_names import renamed_scalars

TAIL = 0.05
"""Share of a run's iterations that counts as the end of training."""

_STUDY_NAME = re.compile(r"(.+)-s(\d+)")


Scalars = dict[str, tuple[np.ndarray, np.ndarray]]
"""Tag -> iterations and values, both of shape (n,)."""


@dataclass
class TrainingRun:
    """One training, possibly in several folders because it was continued."""

    label: str
    """Label of the training: runs of one label differ in the seed only."""
    seed: int | None
    folders: list[Path]
    scalars: Scalars = field(default_factory=dict)
    task: str | None = None
    """Id of the task; None if the run does not tell."""
    start: TrainingRun | None = None
    """The run from whose checkpoint this one began, where that one is there, too."""
    damaged: list[str] = field(default_factory=list)
    """A line for each event file that cannot be read to its end."""

    def find(self, tags: Sequence[str]) -> tuple[np.ndarray, np.ndarray] | None:
        """The curve of the first tag that there is."""
        return next((self.scalars[tag] for tag in tags if tag in self.scalars), None)

    @property
    def iterations(self) -> int:
        """The last iteration."""
        return max((int(steps[-1]) for steps, _ in self.scalars.values() if len(steps)), default=0)

    @property
    def steps_per_iteration(self) -> float:
        """Environment steps in an iteration; 1 if the run does not tell."""
        curve = self.find(["Perf/total_steps"])
        return float(curve[1][-1] / curve[0][-1]) if curve is not None and len(curve[0]) else 1.0

    def at_end(self, tags: Sequence[str], tail: float = TAIL) -> float | None:
        """Mean over the last ``tail`` of the iterations; None without such a curve."""
        curve = self.find(tags)
        if curve is None or not len(curve[0]):
            return None
        return float(curve[1][-max(1, round(len(curve[1]) * tail)) :].mean())


@dataclass
class Group:
    """Runs of one label."""

    label: str
    runs: list[TrainingRun]

    @property
    def task(self) -> str | None:
        """Id of the task of its first run, without the module that registers it."""
        return (self.runs[0].task or "").rpartition(":")[2] or None

    def at_end(self, tags: Sequence[str], tail: float = TAIL) -> list[float]:
        """The end of training of each run that has the curve."""
        values = (run.at_end(tags, tail) for run in self.runs)
        return [value for value in values if value is not None]

    def tags(self) -> set[str]:
        """Scalars that at least one of its runs has."""
        return {tag for run in self.runs for tag, (steps, _) in run.scalars.items() if len(steps)}

    def band(self, tags: Sequence[str]) -> Band | None:
        """Mean, least and greatest over the runs, where at least one has a value; None without such a curve."""
        found = [(run.find(tags), run.steps_per_iteration) for run in self.runs]
        curves = [(curve[0] * scale, curve[1]) for curve, scale in found if curve is not None and len(curve[0])]
        if not curves:
            return None
        x = np.unique(np.concatenate([steps for steps, _ in curves]))
        rows = np.stack([np.interp(x, steps, values, left=np.nan, right=np.nan) for steps, values in curves])
        return Band(x, np.nanmean(rows, 0), np.nanmin(rows, 0), np.nanmax(rows, 0))


@dataclass
class Band:
    """A curve over seeds."""

    steps: np.ndarray
    """Environment steps, all environments together."""
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray


def smooth(values: np.ndarray, weight: float) -> np.ndarray:
    """Exponential moving average as TensorBoard draws it, without its bias at the start.

    Args:
        values: shape (n,).
        weight: of the past, in [0, 1).
    """
    out = np.empty_like(values, dtype=float)
    total, scale = 0.0, 0.0
    for k, value in enumerate(values):
        total = weight * total + (1.0 - weight) * value
        scale = weight * scale + (1.0 - weight)
        out[k] = total / scale
    return out


def read_scalars(folder: str | Path) -> Scalars:
    """All scalars in a folder's event files, those of an older version under their present names.

    Raises:
        FileError: there are no event files.
    """
    if not any(Path(folder).glob("events.out.tfevents.*")):
        raise FileError(f"no event files in '{folder}'")
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    events = EventAccumulator(str(folder), size_guidance={"scalars": 0})  # 0: every point, not 10,000 of them
    events.Reload()
    scalars = {}
    for tag in events.Tags()["scalars"]:
        points = events.Scalars(tag)
        scalars[tag] = (np.array([p.step for p in points], int), np.array([p.value for p in points], float))
    return renamed_scalars(scalars)


def damaged_event_files(folder: str | Path) -> list[str]:
    """A line for each event file of a folder that cannot be read to its end. TensorBoard says nothing of the rest."""
    from tensorboard.backend.event_processing.event_file_loader import RawEventFileLoader

    found = []
    for path in sorted(Path(folder).glob("events.out.tfevents.*")):
        size, good = path.stat().st_size, 0
        for record in RawEventFileLoader(str(path)).Load():
            good += len(record) + 16  # its length, and two checksums
        if good < size:
            found.append(f"'{path}' is damaged after {good} of {size} bytes: later points of its curves are missing")
    return found


def split_place(place: str | Path) -> tuple[str | None, Path]:
    """``"LABEL=FOLDER"`` as label and folder; the label is None without one, as for a folder with ``=`` in its name."""
    label, equals, path = str(place).partition("=")
    return (label, Path(path)) if equals and not Path(place).is_dir() else (None, Path(place))


def find_runs(places: Iterable[str | Path]) -> list[TrainingRun]:
    """The runs in some places, each once.

    Args:
        places: folders of runs, or folders that hold such folders; each may have ``LABEL=`` in front.

    Raises:
        FileError: a place holds no run.
        ConfigError: there are none at all, or a run has two labels.
    """
    labels: dict[Path, str | None] = {}
    for label, place in map(split_place, places):
        found = sorted({events.parent.resolve() for events in place.glob("**/events.out.tfevents.*")})
        if not found:
            raise FileError(f"no training run in '{place}': no event files")
        for folder in found:
            if labels.setdefault(folder, label) != label:
                raise ConfigError(f"'{folder}' is given twice, with different labels")
    if not labels:
        raise ConfigError("no runs given")
    return _join([_Piece(folder, label) for folder, label in labels.items()])


def group_runs(runs: Iterable[TrainingRun]) -> list[Group]:
    """Runs by label, in the order in which the labels first come; without those that have no curves.

    Raises:
        FileError: none has curves.
    """
    runs, groups = list(runs), {}
    for run in runs:
        if run.scalars:
            groups.setdefault(run.label, Group(run.label, [])).runs.append(run)
    if runs and not groups:
        raise FileError(f"no curves in '{runs[0].folders[0]}': its event files are empty")
    return list(groups.values())


def remarks(runs: Sequence[TrainingRun]) -> list[str]:
    """Warnings for a reader of a comparison of these runs: runs without curves or with damaged files, and seeds that
    come twice."""
    found = [f"'{run.folders[0]}' is left out: its event files are empty" for run in runs if not run.scalars]
    found += [line for run in runs for line in run.damaged]
    counts = Counter((run.label, run.seed) for run in runs if run.scalars and run.seed is not None)
    for (label, seed), count in counts.items():
        if count > 1:
            found.append(
                f"'{label}' has {count} runs of seed {seed}, which intervals count as independent: "
                f"leave some out, or tell them apart with LABEL="
            )
    return found


_NO_MATTER = {
    f"{owner}.{name}"
    for owner in ("env", "agent")
    for name in ("seed", "run_name", "experiment_name", "max_iterations", "save_interval", "logger")
}
"""Overrides that do not change what is trained, or only the seed."""


class _Piece:
    """One folder of event files."""

    def __init__(self, folder: Path, label: str | None):
        agent, run = read_params(folder, "agent"), read_params(folder, "run")
        self.folder = folder
        self.name = str(agent.get("run_name") or "")
        self.seed = agent.get("seed")
        self.scalars = read_scalars(folder)
        self.task: str | None = run.get("task")
        named = _STUDY_NAME.fullmatch(self.name)
        self.of_study = named is not None and int(named[2]) == self.seed
        """Whether a study made it, whose pieces of one name are one training."""
        if named is not None and self.of_study:
            label = label or named[1]
        overrides = [text for text in run.get("overrides") or () if text.partition("=")[0] not in _NO_MATTER]
        self.label = label or (" ".join([self.task, *overrides]) if self.task else folder.name)
        self.continues = str(run.get("continues") or "").partition("/")[0]
        """Name of the folder of the run that this one went on from; empty if it began anew."""

    @property
    def first(self) -> int:
        """Its first iteration."""
        return min((int(steps[0]) for steps, _ in self.scalars.values() if len(steps)), default=1)


def _join(pieces: list[_Piece]) -> list[TrainingRun]:
    """Continued runs as one, in the order in which their first pieces are given.

    A run that goes on from another's checkpoint begins with the other's curves, where that one is there, too: the
    two are one if label and seed are the same, and the other was not continued under another name already.
    """
    runs: dict[Path, TrainingRun] = {}
    names: dict[int, str] = {}
    of_study: dict[tuple, TrainingRun] = {}
    for piece in sorted(pieces, key=lambda piece: piece.folder.name):  # names begin with the time
        origin = runs.get(piece.folder.parent / piece.continues) if piece.continues else None
        if origin is None and piece.continues:
            origin = next((run for folder, run in runs.items() if folder.name == piece.continues), None)
        key = (piece.folder.parent, piece.label, piece.name, piece.seed)
        run = of_study.get(key) if piece.of_study else None
        if run is None and origin is not None and (origin.label, origin.seed) == (piece.label, piece.seed):
            newest = origin.folders[-1].name == piece.continues
            run = origin if newest or names[id(origin)] == piece.name else None
        if run is None:
            run = TrainingRun(piece.label, piece.seed, [], task=piece.task, start=origin)
        if piece.of_study:
            of_study[key] = run
        names[id(run)] = piece.name
        runs[piece.folder] = run
        run.folders.append(piece.folder)
        run.damaged += damaged_event_files(piece.folder)
        if piece.scalars:
            earlier = run.scalars or (run.start.scalars if run.start is not None else {})
            run.scalars = _continued(earlier, piece.first, piece.scalars)
    return list({id(runs[piece.folder]): runs[piece.folder] for piece in pieces}.values())


def _continued(earlier: Scalars, first: int, later: Scalars) -> Scalars:
    """Earlier curves up to before iteration `first`, then the later ones: what was done again counts."""
    joined = {tag: (steps[steps < first], values[steps < first]) for tag, (steps, values) in earlier.items()}
    for tag, (steps, values) in later.items():
        old = joined.get(tag, (np.zeros(0, int), np.zeros(0)))
        joined[tag] = (np.concatenate((old[0], steps)), np.concatenate((old[1], values)))
    return joined
