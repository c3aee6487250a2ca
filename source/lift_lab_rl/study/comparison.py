"""Our numbers beside the paper's: tables as data, with intervals over seeds and over episodes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lift_lab.utils.errors import ConfigError, suggest
from lift_lab_rl.intervals import t_interval, welch_interval, wilson_interval

from .curves import TAIL, Group, TrainingRun
from .paper import Claim, Paper

NONE = "-"
"""An empty cell."""


@dataclass
class Table:
    """Rows of text under a header."""

    title: str
    header: list[str]
    rows: list[list[str]] = field(default_factory=list)
    note: str = ""
    is_success: bool = False
    """Whether it is about success, which a report shows first."""


@dataclass
class Roles:
    """Labels that correspond to the paper's two trainings; None where there is none."""

    baseline: str | None = None
    curriculum: str | None = None

    @classmethod
    def guess(
        cls, groups: Sequence[Group], paper: Paper, baseline: str | None = None, curriculum: str | None = None
    ) -> Roles:
        """The labels that were asked for; in place of None the first that was trained on the paper's task.

        Raises:
            ConfigError: there are no runs of a label that was asked for, or one label is to be both.
        """
        for name in (baseline, curriculum):
            if name is not None and name not in (labels := [group.label for group in groups]):
                raise ConfigError(f"no runs are labelled '{name}': {suggest(name, labels)}")
        if baseline is not None and baseline == curriculum:
            raise ConfigError(f"'{baseline}' cannot be both baseline and curriculum")
        asked = (baseline, curriculum)
        found = [
            next((group.label for group in groups if group.task == task and group.label not in asked), None)
            for task in (paper.baseline_task, paper.curriculum_task)
        ]
        return cls(baseline or found[0], curriculum or found[1])

    def ordered(self, groups: Sequence[Group]) -> list[Group]:
        """Groups in the paper's order: baseline, curriculum, then the others as they are."""
        ranks = {self.baseline: 0, self.curriculum: 1}
        return sorted(groups, key=lambda group: ranks.get(group.label, 2))


def number(value: float | None) -> str:
    """A value as text: four digits that matter, from 100 on two decimals."""
    if value is None or not math.isfinite(value):
        return NONE
    if value == 0:
        return "0"
    decimals = max(2, 3 - math.floor(math.log10(abs(value))))
    return f"{value:,.{min(decimals, 4)}f}" if abs(value) >= 1e-3 else f"{value:.2e}"


def mean_with_interval(values: Sequence[float]) -> str:
    """Mean over seeds and its 95 % interval (Student's)."""
    if not values:
        return NONE
    ends = t_interval(values)
    text = number(float(np.mean(values)))
    return text if ends is None else f"{text} [{number(ends[0])}, {number(ends[1])}]"


def rate_with_interval(successes: int, trials: int) -> str:
    """A rate in percent and its 95 % interval (Wilson's)."""
    low, high = wilson_interval(successes, trials)
    return f"{successes / trials:.1%} [{low:.1%}, {high:.1%}]"


# -- curves


def runs_table(groups: Sequence[Group]) -> Table:
    """Label of the trainings."""
    table = Table("Runs", ["label", "seed", "iterations", "steps (M)", "hours", "folders"])
    for group in groups:
        for run in group.runs:
            times = [run.find([f"Perf/{part}_time"]) for part in ("collection", "learning")]
            seconds = sum(curve[1].sum() for curve in times if curve is not None)
            steps = run.iterations * run.steps_per_iteration / 1e6
            seed = NONE if run.seed is None else str(run.seed)
            folders = ", ".join(folder.name for folder in run.folders)
            hours = f"{seconds / 3600:.2f}"
            table.rows.append([group.label, seed, str(run.iterations), f"{steps:.1f}", hours, folders])
    return table


def numbers_table(groups: Sequence[Group], paper: Paper, roles: Roles, tail: float = TAIL) -> Table:
    """The end of training beside the paper's numbers, figure by figure."""
    table = Table(
        "End of training",
        ["figure", "paper: baseline", "paper: curriculum", *(group.label for group in groups)],
        note=f"Ours: the mean over the last {tail:.0%} of the iterations, then over seeds. In brackets: the 95 % "
        f"interval over seeds (Student's t). The paper trained for {paper.total_steps / 1e6:.1f} M steps. Its baseline "
        f"is compared with {roles.baseline or 'none of these runs'}, its curriculum with "
        f"{roles.curriculum or 'none of these runs'}.",
    )
    for figure in (*paper.figures, *paper.further):
        ours = [group.at_end(figure.tags, tail) for group in groups]
        if any(ours):
            name = f"{figure.number} {figure.title}" if figure.number else figure.title
            cells = [number(figure.baseline), number(figure.curriculum), *map(mean_with_interval, ours)]
            table.rows.append([name + (f" ({figure.unit})" if figure.unit else ""), *cells])
    return table


def training_success_table(groups: Sequence[Group], success_tags: Sequence[str], tail: float = TAIL) -> Table:
    """Success of training episodes at the end of training."""
    table = Table(
        "Success at the end of training",
        ["label", "each seed", "mean of seeds"],
        note=f"Share of the training episodes that succeeded, mean over the last {tail:.0%} of the iterations. These "
        "episodes have exploration noise.",
        is_success=True,
    )
    for group in groups:
        ends = group.at_end(success_tags, tail)
        if ends:
            table.rows.append([group.label, ", ".join(f"{end:.1%}" for end in ends), f"{np.mean(ends):.1%}"])
    return table


def jump_table(groups: Sequence[Group], success_tags: Sequence[str], window: int = 50) -> Table:
    """Success of training episodes before and after a curriculum's weight jumps, run by run."""
    table = Table(
        "Success when the penalties increase",
        ["label", "seed", "iteration", f"mean of {window} before", f"least of {window} after", "end"],
        note="Found where the weight of a penalty changes by more than 40 % of its range within one iteration. "
        f"Success is that of training episodes, in {window} iterations before and after.",
        is_success=True,
    )
    for group in groups:
        for run in group.runs:
            at, success = _jump(run), run.find(success_tags)
            if at is None or success is None:
                continue
            steps, values = success
            before = values[(steps < at) & (steps >= at - window)]
            after = values[(steps >= at) & (steps < at + window)]
            seed = NONE if run.seed is None else str(run.seed)
            cells = [f"{v:.1%}" for v in (before.mean() if len(before) else np.nan, after.min())]
            table.rows.append([group.label, seed, str(at), *cells, f"{run.at_end(success_tags):.1%}"])
    return table


def _jump(run: TrainingRun) -> int | None:
    """Iteration of the first jump of a penalty's weight; None without one."""
    found = []
    for tag, (steps, values) in run.scalars.items():
        if tag.startswith("Curriculum/") and values.max() <= 0 and np.ptp(values) > 0:  # penalties weigh below zero
            jumps = np.flatnonzero(np.abs(np.diff(values)) > 0.4 * np.ptp(values))
            found += [int(steps[jumps[0] + 1])] if len(jumps) else []
    return min(found, default=None)


# -- evaluations


def _entries(results: dict[str, Any], label: str) -> list[dict[str, Any]]:
    """Evaluations of the runs of a label."""
    return [run["evaluation"] for run in results.get("runs", []) if run["label"] == label and run.get("evaluation")]


def success_table(results: dict[str, Any], labels: Sequence[str], paper: Paper, roles: Roles) -> Table:
    """Successes of evaluations, the paper's and ours."""
    table = Table(
        paper.table_title,
        ["model", "episodes", "paper", "each seed", "all seeds [95 %]"],
        note="Ours: the first episodes of each seed's evaluation, without exploration noise. In brackets: Wilson's "
        "95 % interval over the episodes of all seeds.",
        is_success=True,
    )
    for label in labels:
        evaluations = _entries(results, label)
        counts = sorted({int(count) for entry in evaluations for count in entry["success_rate"]})
        for count in counts:
            rates = [entry["success_rate"][str(count)] for entry in evaluations if str(count) in entry["success_rate"]]
            wins = [round(rate * count) for rate in rates]
            printed = NONE
            for row in paper.table:
                if row.episodes == count and label in (roles.baseline, roles.curriculum):
                    printed = f"{row.baseline if label == roles.baseline else row.curriculum} of {count}"
            each = ", ".join(map(str, wins))
            table.rows.append([label, str(count), printed, each, rate_with_interval(sum(wins), count * len(wins))])
    return table


_EVALUATION_ROWS = (
    ("mean total reward", "mean_reward"),
    ("minimum total reward", "min_reward"),
    ("maximum total reward", "max_reward"),
    ("mean episode length (steps)", "mean_episode_length"),
    ("shortest episode (steps)", "min_episode_length"),
    ("time to success (s)", "time_to_success_s"),
)


def evaluation_table(results: dict[str, Any], labels: Sequence[str]) -> Table:
    """Table of the policies' results without exploration noise."""
    table = Table(
        "Evaluation",
        ["measure", *labels],
        note="The policies act without exploration noise. Mean over seeds. In brackets: its 95 % interval (Student's "
        "t).",
    )
    entries = {label: _entries(results, label) for label in labels}
    logs = dict.fromkeys(key for some in entries.values() for entry in some for key in entry.get("logs", {}))
    rows = [*_EVALUATION_ROWS, *((key, key) for key in logs if not key.startswith("Metrics/physics/"))]
    for name, key in rows:
        cells = [mean_with_interval(_values(entries[label], key)) for label in labels]
        if any(cell != NONE for cell in cells):
            table.rows.append([name, *cells])
    return table


def _value(entry: dict[str, Any], key: str) -> float | None:
    """A figure of an evaluation, or None; ``success_rate`` is the rate over all its episodes."""
    if key == "success_rate":
        return entry["success_rate"].get(str(entry["episodes"]))
    return entry.get(key, entry.get("logs", {}).get(key))


def _values(entries: Sequence[dict[str, Any]], key: str) -> list[float]:
    """A figure of each evaluation that has it."""
    found = (_value(entry, key) for entry in entries)
    return [float(value) for value in found if value is not None]


def generalisation_table(results: dict[str, Any], labels: Sequence[str]) -> Table:
    """Success under perturbations, over the episodes of all seeds."""
    table = Table(
        "Success under perturbations",
        ["perturbation", *labels],
        note="mass and friction: factors. pose: starts outside the trained range, within this factor of it. delay: of "
        "actions, in s. In brackets: Wilson's 95 % interval over the episodes of all seeds.",
        is_success=True,
    )
    names = dict.fromkeys(name for run in results.get("runs", []) for name in run.get("perturbed", {}))
    for name in ("none", *names):
        cells = []
        for label in labels:
            runs = [run for run in results.get("runs", []) if run["label"] == label]
            entries = [run.get("evaluation") if name == "none" else run.get("perturbed", {}).get(name) for run in runs]
            found = [entry for entry in entries if entry]
            trials = sum(entry["episodes"] for entry in found)
            wins = sum(round(entry["success_rate"][str(entry["episodes"])] * entry["episodes"]) for entry in found)
            cells.append(rate_with_interval(wins, trials) if trials else NONE)
        table.rows.append([name, *cells])
    return table if names else Table(table.title, table.header)


# -- claims


def claims_table(
    groups: Sequence[Group], results: dict[str, Any], paper: Paper, roles: Roles, tail: float = TAIL
) -> Table:
    """The paper's claims one by one, and whether our difference has their direction."""
    table = Table(
        "The paper's claims",
        ["curriculum against baseline", "paper", "baseline", "curriculum", "difference [95 %]", "direction"],
        note="In brackets: the 95 % interval of the difference of means over seeds. 'undecided': the interval "
        "contains 0. It is Student's t of the differences within each seed where all runs of one side began from the "
        "other's of the same seed, else Welch's.",
    )
    by_label = {group.label: group for group in groups}
    sides = [by_label.get(label or "") for label in (roles.baseline, roles.curriculum)]
    paired = began_from(sides[0], sides[1]) or began_from(sides[1], sides[0])
    for claim in paper.claims:
        first, second = (_claimed(side, results, claim, tail) for side in sides)
        if not first or not second:
            continue
        values = [[value for _, value in side] for side in (first, second)]
        difference = float(np.mean(values[1]) - np.mean(values[0]))
        if paired and sorted(seed for seed, _ in first) == sorted(seed for seed, _ in second):
            before = dict(first)
            ends = t_interval([value - before[seed] for seed, value in second])
        else:
            ends = welch_interval(values[0], values[1])
        shown = number(difference) + (f" [{number(ends[0])}, {number(ends[1])}]" if ends else "")
        cells = [claim.text, claim.printed, *(number(float(np.mean(side))) for side in values)]
        table.rows.append([*cells, shown, verdict(claim.sign, difference, ends)])
    return table


def began_from(later: Group | None, earlier: Group | None) -> bool:
    """Whether every run of a group began from a checkpoint of the other group's run of the same seed."""
    if later is None or earlier is None:
        return False
    starts = [(run.start.label, run.start.seed) if run.start is not None else None for run in later.runs]
    seeds = [run.seed for run in later.runs]
    return len(set(seeds)) == len(seeds) and starts == [(earlier.label, seed) for seed in seeds]


def _claimed(group: Group | None, results: dict[str, Any], claim: Claim, tail: float) -> list[tuple[Any, float]]:
    """Seed and value of what decides a claim, run by run."""
    if group is None:
        return []
    key = claim.tag.removeprefix("evaluation:")
    if key == claim.tag:
        found = [(run.seed, run.at_end([key], tail)) for run in group.runs]
    else:
        runs = [run for run in results.get("runs", []) if run["label"] == group.label and run.get("evaluation")]
        found = [(run.get("seed"), _value(run["evaluation"], key)) for run in runs]
    return [(seed, float(value)) for seed, value in found if value is not None]


def verdict(sign: int, difference: float, ends: tuple[float, float] | None) -> str:
    """Whether a difference has the direction of a claim.

    Args:
        sign: the claim's direction.
        difference: ours.
        ends: its interval; None for one seed.
    """
    if ends is not None and ends[0] <= 0.0 <= ends[1]:
        return "undecided"
    text = "as the paper" if difference * sign > 0 else "opposite" if difference else "undecided"
    return text if ends is not None else f"{text} (too few seeds for an interval)"
