"""Curves of training runs, read from TensorBoard's event files: pieces of a continued run joined, seeds grouped."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from lift_lab.utils.errors import ConfigError, FileError
from lift_lab_rl.run_params import read_params

TAIL = 0.05
"""Share of a run's iterations that counts as the end of training."""

_STUDY_NAME = re.compile(r"(.+)-s(\d+)")


Scalars = dict[str, tuple[np.ndarray, np.ndarray]]
"""Tag -> iterations and values, both of shape (n,)."""


@dataclass
class TrainingRun:
    """One training, possibly in several folders because it was continued."""

    label: str
    """What was trained: runs of one label differ in the seed only."""
    seed: int | None
    folders: list[Path]
    scalars: Scalars = field(default_factory=dict)

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

    def at_end(self, tags: Sequence[str], tail: float = TAIL) -> list[float]:
        """The end of training of each run that has the curve."""
        values = (run.at_end(tags, tail) for run in self.runs)
        return [value for value in values if value is not None]

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
    """All scalars in a folder's event files.

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
    return scalars


def find_runs(places: Iterable[str | Path]) -> list[TrainingRun]:
    """The runs in some places.

    Args:
        places: folders of runs, or folders that hold such folders; each may have ``LABEL=`` in front.

    Raises:
        FileError: a place holds no run.
        ConfigError: there are none at all.
    """
    pieces = []
    for place in places:
        label, equals, path = str(place).partition("=")
        if not equals or Path(place).is_dir():
            label, path = None, str(place)
        folder = Path(path)
        found = sorted({events.parent for events in folder.glob("**/events.out.tfevents.*")})
        if not found:
            raise FileError(f"no training run in '{folder}': no event files")
        pieces += [_Piece(found_folder, label) for found_folder in found]
    if not pieces:
        raise ConfigError("no runs given")
    return _join(pieces)


def group_runs(runs: Iterable[TrainingRun]) -> list[Group]:
    """Runs by label, in the order in which the labels first come."""
    groups: dict[str, Group] = {}
    for run in runs:
        groups.setdefault(run.label, Group(run.label, [])).runs.append(run)
    return list(groups.values())


class _Piece:
    """One folder of event files."""

    def __init__(self, folder: Path, label: str | None):
        agent = read_params(folder, "agent")
        self.folder = folder
        self.name = str(agent.get("run_name") or "")
        self.seed = agent.get("seed")
        self.scalars = read_scalars(folder)
        named = _STUDY_NAME.fullmatch(self.name)
        if label is None and named is not None and int(named[2]) == self.seed:
            label = named[1]
        run = read_params(folder, "run")
        self.label = label or run.get("task") or folder.name
        self.continues = str(run.get("continues") or "").partition("/")[0]
        """Name of the folder of the run that this one went on from; empty if it began anew."""

    @property
    def first(self) -> int:
        """Its first iteration."""
        return min((int(steps[0]) for steps, _ in self.scalars.values() if len(steps)), default=1)


def _join(pieces: list[_Piece]) -> list[TrainingRun]:
    """Continued runs as one. Folder names begin with the time, so that their order is that of the pieces.

    A run that goes on from another's checkpoint begins with the other's curves, where that one is there, too.
    """
    runs: list[TrainingRun] = []
    by_key: dict[tuple, TrainingRun] = {}
    by_folder: dict[str, TrainingRun] = {}
    branches: list[tuple[_Piece, TrainingRun]] = []
    for piece in pieces:
        key = (piece.folder.parent, piece.label, piece.name, piece.seed)
        run = by_key.get(key)
        if run is None or (not piece.name and piece.first == 1):
            run = TrainingRun(piece.label, piece.seed, [])
            runs.append(run)
            by_key[key] = run
            if piece.continues:
                branches.append((piece, run))
        by_folder[piece.folder.name] = run
        run.folders.append(piece.folder)
        run.scalars = _continued(run.scalars, piece.first, piece.scalars)
    for piece, run in sorted(branches, key=lambda branch: branch[0].folder.name):  # by time: a branch may have branches
        origin = by_folder.get(piece.continues)
        if origin is not None and origin is not run:
            run.scalars = _continued(origin.scalars, piece.first, run.scalars)
    return runs


def _continued(earlier: Scalars, first: int, later: Scalars) -> Scalars:
    """Earlier curves up to before iteration `first`, then the later ones: what was done again counts."""
    joined = {tag: (steps[steps < first], values[steps < first]) for tag, (steps, values) in earlier.items()}
    for tag, (steps, values) in later.items():
        old = joined.get(tag, (np.zeros(0, int), np.zeros(0)))
        joined[tag] = (np.concatenate((old[0], steps)), np.concatenate((old[1], values)))
    return joined
