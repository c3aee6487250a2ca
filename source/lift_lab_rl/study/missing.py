"""Data that a paper's figures and claims need and that runs lack, for example a reward term that was renamed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from .curves import Group
from .paper import Paper

_EVALUATION = "evaluation:"
_MOST = 8
"""Names that a line lists; more are counted."""


def missing_scalars(groups: Sequence[Group], results: dict[str, Any], paper: Paper) -> list[str]:
    """A line for each label and group of scalars in which something is missing.

    A line names what was looked for, and for which figure, and what there is in its place: the scalars of that group
    that no figure of the paper stands for.

    Args:
        groups: what was trained.
        results: evaluations, as of :func:`~lift_lab_rl.study.evaluations.collect`; may be empty.
        paper: the paper.
    """
    lines = []
    for group in groups:
        figures = (*paper.figures, *paper.further)
        known = [figure.tags for figure in figures]
        never = _never_succeeded(group, paper)
        wanted = {f.tags: _name(f.number, f.title) for f in figures if not (never and f.needs_success)}
        lines += _lines(f"the runs of '{group.label}'", wanted, group.tags(), known)
        evaluations = [run["evaluation"] for run in results.get("runs", []) if run["label"] == group.label]
        logs = {key for entry in evaluations if entry for key in entry.get("logs", {})}
        if logs:
            claims = [(claim.tag.removeprefix(_EVALUATION), claim) for claim in paper.claims]
            in_logs = {(tag,): f"'{claim.text}'" for tag, claim in claims if tag != claim.tag and "/" in tag}
            lines += _lines(f"the evaluations of '{group.label}'", in_logs, logs, known)
    return lines


def _never_succeeded(group: Group, paper: Paper) -> bool:
    """Whether the runs log success, and no episode had any."""
    curves = [curve for run in group.runs if (curve := run.find(paper.success_tags)) is not None]
    return bool(curves) and not any((values > 0).any() for _, values in curves)


def _name(number: int, title: str) -> str:
    return f"Fig. {number} {title}" if number else title


def _lines(
    owner: str, wanted: dict[tuple[str, ...], str], present: set[str], known: Iterable[tuple[str, ...]]
) -> Iterator[str]:
    """Lines about one set of scalars, one for each group of tags."""
    named = {tag for tags in known for tag in tags}
    missing: dict[str, list[str]] = {}
    for tags, name in wanted.items():
        if not present & set(tags):
            missing.setdefault(tags[0].partition("/")[0], []).append(f"{' or '.join(tags)} ({name})")
    for prefix, names in missing.items():
        others = sorted(tag for tag in present - named if tag.startswith(f"{prefix}/"))
        found = f"they have {_listed(others)}, which no figure uses" if others else f"they have no other {prefix}/..."
        yield f"{owner} have no {_listed(names)}; {found}"


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(names[:_MOST])
    return shown if len(names) <= _MOST else f"{shown} and {len(names) - _MOST} more"
