"""The form of a paper's results, for a report that compares ours with them. A task's ``paper.py`` has the numbers."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Figure:
    """One of the paper's figures."""

    number: int
    title: str
    """Its caption."""
    tags: tuple[str, ...]
    """Our scalars for the same quantity; the first that a run has is taken."""
    unit: str = ""
    baseline: float | None = None
    """The paper's value at the end of the baseline's training; None if the text has none."""
    curriculum: float | None = None
    needs_success: bool = False
    """Whether the scalar is written only after an episode with success."""


@dataclass(frozen=True)
class Trials:
    """A row of the table of evaluations."""

    episodes: int
    baseline: int
    """Successes of the baseline."""
    curriculum: int


@dataclass(frozen=True)
class Claim:
    """A difference that the paper finds between curriculum and baseline."""

    text: str
    tag: str
    """Scalar at the end of training that decides it; with ``evaluation:`` in front, a key of the evaluation."""
    sign: int
    """1 if the curriculum's is larger, -1 if smaller."""
    printed: str
    """Its numbers, or its words."""


@dataclass(frozen=True)
class Paper:
    """Results of a baseline and of a curriculum, as printed."""

    citation: str
    """Title, and where known authors, year and DOI."""
    baseline_task: str
    """Our task that corresponds to the paper's baseline."""
    curriculum_task: str
    """Our task that corresponds to its curriculum."""
    total_steps: int
    """Environment steps of each of its two trainings."""
    figures: tuple[Figure, ...]
    further: tuple[Figure, ...]
    """Quantities that it measures without a figure."""
    table_title: str
    table: tuple[Trials, ...]
    """Successes of evaluations, row by row."""
    claims: tuple[Claim, ...]
    success_tags: tuple[str, ...]
    """Scalars that hold the success rate of training episodes; the first that a run has is taken."""
