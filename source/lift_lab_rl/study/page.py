"""The report: one HTML page that needs nothing beside it, and the figures as files."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lift_lab_rl.files import write_atomically

from . import comparison
from .comparison import Roles, Table
from .curves import TAIL, Group
from .figures import draw, file_stem, require_matplotlib, save
from .paper import Paper

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 76rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
table { border-collapse: collapse; margin: .5rem 0 1rem; font-size: 13px; display: block; overflow-x: auto; }
th, td { border-bottom: 1px solid #ddd; padding: .25rem .6rem; text-align: left; vertical-align: top; }
th { background: #f4f4f4; } td { font-variant-numeric: tabular-nums; }
figure { margin: 1rem 0; } figure img { max-width: 100%; } figcaption, .note { color: #666; font-size: 13px; }
"""


def tables(
    groups: Sequence[Group], results: dict[str, Any], paper: Paper, roles: Roles, tail: float = TAIL
) -> list[Table]:
    """All tables that have rows."""
    labels = [group.label for group in groups]
    made = [
        comparison.success_table(results, labels, paper, roles),
        comparison.claims_table(groups, results, paper, roles, tail),
        comparison.numbers_table(groups, paper, roles, tail),
        comparison.evaluation_table(results, labels),
        comparison.jump_table(groups, paper.success_tags),
        comparison.generalisation_table(results, labels),
        comparison.runs_table(groups),
    ]
    return [table for table in made if table.rows]


def write_report(
    groups: Sequence[Group],
    results: dict[str, Any],
    paper: Paper,
    roles: Roles,
    out: str | Path,
    title: str = "Curriculum against baseline",
    tail: float = TAIL,
    smoothing: float = 0.9,
    notes: Sequence[str] = (),
) -> Path:
    """Write ``report.html``, ``figures/*.png`` and ``figures/*.pdf``.

    Args:
        groups: what was trained.
        results: evaluations, as of :func:`~lift_lab_rl.study.evaluations.collect`; may be empty.
        paper: results to set beside ours.
        roles: which labels correspond to the paper's.
        out: folder.
        title: heading.
        tail: share of the iterations that counts as the end of training.
        smoothing: of the curves, in [0, 1).
        notes: what a reader has to know.

    Returns:
        The page.

    Raises:
        ConfigError: matplotlib is not installed.
    """
    require_matplotlib()
    folder = Path(out)
    pictures = []
    for figure in (*paper.figures, *paper.further):
        ends = {roles.baseline: figure.baseline, roles.curriculum: figure.curriculum}
        plot = draw(figure, groups, {label: end for label, end in ends.items() if label}, smoothing)
        if plot is not None:
            png, _ = save(plot, folder / "figures", file_stem(figure))
            caption = f"Fig. {figure.number}. {figure.title}" if figure.number else figure.title
            pictures.append((caption, png))
    page = folder / "report.html"
    write_atomically(page, _html(title, tables(groups, results, paper, roles, tail), pictures, results, notes).encode())
    return page


def _html(
    title: str,
    made: Sequence[Table],
    pictures: Sequence[tuple[str, Path]],
    results: dict[str, Any],
    notes: Sequence[str],
) -> str:
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style></head><body>",
        f"<h1>{html.escape(title)}</h1>",
    ]
    if "command" in results:
        parts.append(f"<p class='note'>Made by <code>{html.escape(results['command'])}</code></p>")
    parts += [f"<p>Note: {html.escape(note)}</p>" for note in notes]
    parts += [_table(table) for table in made]
    parts.append("<h2>Curves</h2><p class='note'>Thin: mean over seeds; thick: the same, smoothed; shaded: least to "
                 "greatest over seeds; dashed: the study's end value.</p>")  # fmt: skip
    for caption, png in pictures:
        data = base64.b64encode(png.read_bytes()).decode()
        text = html.escape(caption)
        parts.append(
            f'<figure><img alt="{text}" src="data:image/png;base64,{data}"><figcaption>{text}</figcaption></figure>'
        )
    return "\n".join([*parts, "</body></html>", ""])


def _table(table: Table) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in table.header)
    body = "\n".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in table.rows)
    note = f"<p class='note'>{html.escape(table.note)}</p>" if table.note else ""
    return f"<h2>{html.escape(table.title)}</h2><table><tr>{head}</tr>\n{body}</table>{note}"
