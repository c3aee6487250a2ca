"""Evaluations of training runs: read from the results files of studies, and matched with the runs of a report."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from lift_lab.utils.errors import FileError
from lift_lab_rl.files import read_json
from lift_lab_rl.scalar_names import renamed_evaluation

from .curves import TrainingRun

RESULTS = "results.json"
"""File of a study's evaluations, beside its runs."""


def load_results(path: str | Path) -> dict[str, Any]:
    """A study's results file.

    Raises:
        FileError: there is none, or it is something else.
    """
    content = read_json(path)
    runs = content.get("runs") if isinstance(content, dict) else None
    if not isinstance(runs, list):
        raise FileError(f"'{path}' is no {RESULTS} of lift-lab study: it has no 'runs'")
    for run in runs:
        missing = [key for key in ("label", "seed") if not isinstance(run, dict) or key not in run]
        if missing:
            raise FileError(f"'{path}' is no {RESULTS} of lift-lab study: a run has no '{missing[0]}'")
        perturbed = run.get("perturbed") or {}
        if run.get("evaluation"):
            run["evaluation"] = _evaluation(run["evaluation"], run["label"], path)
        if perturbed:
            run["perturbed"] = {name: _evaluation(entry, run["label"], path) for name, entry in perturbed.items()}
    return content


def _evaluation(entry: Any, label: str, path: str | Path) -> dict[str, Any]:
    """An evaluation under the present keys, or an error if it lacks what every evaluation has."""
    found = renamed_evaluation(entry) if isinstance(entry, dict) else {}
    if not isinstance(found.get("success_rate"), dict) or "episodes" not in found:
        raise FileError(f"'{path}': an evaluation of '{label}' has no 'success_rate' or no 'episodes'")
    return found


def find_results(runs: Iterable[TrainingRun]) -> list[Path]:
    """The results files beside some runs."""
    folders = dict.fromkeys(folder.parent for run in runs for folder in run.folders)
    return [folder / RESULTS for folder in folders if (folder / RESULTS).is_file()]


def collect(paths: Sequence[Path], runs: Sequence[TrainingRun]) -> tuple[dict[str, Any], list[str]]:
    """The evaluations of some runs, each under its run's label.

    An evaluation is of the run in whose folder its checkpoint is, or with no checkpoint of the run of its label and
    seed. Studies may have been moved: the folder's name decides, and its place only among several of that name.

    Args:
        paths: results files.
        runs: runs of the report.

    Returns:
        What :func:`load_results` gives, of all files together, and a line for each evaluation that is of no run.
    """
    entries, left_out, commands = [], [], []
    for path in paths:
        content = load_results(path)
        commands += [content["command"]] if "command" in content else []
        for entry in content["runs"]:
            if not entry.get("evaluation") and not entry.get("perturbed"):
                continue
            run = _run_of(entry, path, runs)
            if run is None:
                left_out.append(
                    f"the evaluation of '{entry['label']}', seed {entry['seed']}, in '{path}' is not shown: "
                    f"its run is not among those given"
                )
            else:
                entries.append({**entry, "label": run.label, "seed": run.seed})
    merged: dict[str, Any] = {"runs": entries}
    return merged | ({"command": commands[0]} if len(commands) == 1 else {}), left_out


def _run_of(entry: dict[str, Any], path: Path, runs: Sequence[TrainingRun]) -> TrainingRun | None:
    checkpoint = entry.get("checkpoint")
    if not checkpoint:
        same = ((run.label, run.seed) == (entry["label"], entry["seed"]) for run in runs)
        return next((run for run, is_same in zip(runs, same, strict=True) if is_same), None)
    place = Path(checkpoint).parent
    found = [(folder, run) for run in runs for folder in run.folders if folder.name == place.name]
    found = [(folder, run) for folder, run in found if run.seed in (None, entry["seed"])]
    beside = path.resolve().parent / place.name
    exact = [run for folder, run in found if folder in (beside, place)]
    if exact or (path.name == RESULTS and beside.is_dir()):  # the runs beside the file are those that it is about
        return exact[0] if exact else None
    return found[0][1] if found else None
