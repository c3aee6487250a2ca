"""The report: one HTML page that needs nothing beside it, and the figures as files."""

from __future__ import annotations

import base64
import html
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lift_lab_rl.files import write_atomically

from . import comparison
from .comparison import Roles, Table
from .curves import TAIL, Group
from .figures import draw, file_stem, require_matplotlib, save
from .paper import Figure, Paper
from .style import STYLE


@dataclass
class Picture:
    """A figure of the report."""

    figure: Figure
    """Contents of the section."""
    tag: str
    """The scalar that is drawn."""
    panels: int
    """Panels side by side."""
    png: Path
    """Its file."""

    @property
    def title(self) -> str:
        """Its number in the paper, if it has one, and its title."""
        number = self.figure.number
        return f"Fig. {number}. {self.figure.title}" if number else self.figure.title


@dataclass
class Section:
    """A part of the page with a heading of its own."""

    title: str
    body: str
    """HTML below the heading."""
    entries: Sequence[tuple[str, str]] = ()
    """Anchor and title of what the table of contents lists below the heading."""

    @property
    def anchor(self) -> str:
        """Target of a link to it."""
        return _anchor(self.title)


def tables(
    groups: Sequence[Group], results: dict[str, Any], paper: Paper, roles: Roles, tail: float = TAIL
) -> list[Table]:
    """All tables that have rows, success first."""
    labels = [group.label for group in groups]
    made = [
        comparison.success_table(results, labels, paper, roles),
        comparison.training_success_table(groups, paper.success_tags, tail),
        comparison.jump_table(groups, paper.success_tags),
        comparison.generalisation_table(results, labels),
        comparison.claims_table(groups, results, paper, roles, tail),
        comparison.numbers_table(groups, paper, roles, tail),
        comparison.evaluation_table(results, labels),
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
        paper: results to compare ours with.
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
    pictures = [
        picture
        for figure in (*paper.further, *paper.figures)
        if (picture := _picture(figure, groups, roles, folder / "figures", smoothing)) is not None
    ]
    sections = _sections(tables(groups, results, paper, roles, tail), pictures, paper, notes)
    page = folder / "report.html"
    write_atomically(page, _html(title, _introduction(groups, results, paper, roles, notes), sections).encode())
    return page


def _picture(figure: Figure, groups: Sequence[Group], roles: Roles, folder: Path, smoothing: float) -> Picture | None:
    """Draw a figure; None if no group has its curve."""
    ends = {roles.baseline: figure.baseline, roles.curriculum: figure.curriculum}
    plot = draw(figure, groups, {label: end for label, end in ends.items() if label}, smoothing)
    if plot is None:
        return None
    known = [group.tags() for group in groups]
    tag = next(tag for tag in figure.tags if any(tag in tags for tags in known))
    panels = sum(not tags.isdisjoint(figure.tags) for tags in known)
    return Picture(figure, tag, panels, save(plot, folder, file_stem(figure))[0])


# -- the page


def _introduction(
    groups: Sequence[Group], results: dict[str, Any], paper: Paper, roles: Roles, notes: Sequence[str]
) -> str:
    """What is compared with what."""
    runs = sum(len(group.runs) for group in groups)
    trained = f"{runs} training run{'s' if runs != 1 else ''} of {_listed([group.label for group in groups])}"
    sides = [
        f"<strong>{html.escape(label)}</strong> with its {side}"
        for side, label in (("baseline", roles.baseline), ("curriculum", roles.curriculum))
        if label
    ]
    compared = f"We compare {' and '.join(sides)}." if sides else "None of the runs is of a task of the paper."
    hint = f" Read the <a href='#{_anchor('Notes')}'>notes</a> first." if notes else ""
    parts = [
        f"<p>This page shows {trained}. The paper is <cite>{html.escape(paper.citation)}</cite>. {compared}{hint}</p>"
    ]
    if "command" in results:
        parts.append(f"<p class='note'>Made by <code>{html.escape(results['command'])}</code></p>")
    return "\n".join(parts)


def _sections(made: Sequence[Table], pictures: Sequence[Picture], paper: Paper, notes: Sequence[str]) -> list[Section]:
    """The page's parts: success with its curve, notes, the other tables, the other curves."""
    first = [picture for picture in pictures if picture.tag in paper.success_tags]
    others = [picture for picture in pictures if picture not in first]
    success = [table for table in made if table.is_success]
    sections = []
    if success or first:
        parts = [f"<h3 id='{_anchor(table.title)}'>{html.escape(table.title)}</h3>{_table(table)}" for table in success]
        parts += map(_figure, first)
        entries = [(_anchor(table.title), table.title) for table in success]
        entries += [(_anchor(picture.title), picture.title) for picture in first]
        sections.append(Section("Success", "\n".join(parts), entries))
    if notes:
        items = "".join(f"<li>{html.escape(note)}</li>" for note in notes)
        sections.append(Section("Notes", f"<ul class='notes'>{items}</ul>"))
    runs = [table for table in made if table.title == "Runs"]
    sections += [Section(t.title, _table(t)) for t in made if not t.is_success and t not in runs]
    if others:
        legend = (
            "<p class='note'>Thin line: mean over seeds. Thick line: the same, smoothed. Shaded: from the lowest to "
            "the highest seed. Dashed: the paper's value at the end of training.</p>"
        )
        ordered = sorted(others, key=lambda picture: picture.figure.number or 1000)
        entries = [(_anchor(picture.title), picture.title) for picture in ordered]
        sections.append(Section("Curves", legend + "\n".join(map(_figure, ordered)), entries))
    sections += [Section(table.title, _table(table)) for table in runs]
    return sections


def _html(title: str, introduction: str, sections: Sequence[Section]) -> str:
    contents = "".join(
        f"<li><a href='#{section.anchor}'>{html.escape(section.title)}</a>{_entries(section)}</li>"
        for section in sections
    )
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta name="color-scheme" content="light dark">',
        f"<title>{html.escape(title)}</title><style>{STYLE}</style></head><body>",
        f"<nav aria-label='Contents'><details open><summary>Contents</summary><ul>{contents}</ul></details></nav>",
        f"<main><h1>{html.escape(title)}</h1>",
        introduction,
    ]
    for section in sections:
        heading = f"<h2 id='{section.anchor}'>{html.escape(section.title)}</h2>"
        parts.append(f"<section>{heading}{section.body}</section>")
    return "\n".join([*parts, "</main></body></html>", ""])


def _entries(section: Section) -> str:
    items = "".join(f"<li><a href='#{anchor}'>{html.escape(title)}</a></li>" for anchor, title in section.entries)
    return f"<ul>{items}</ul>" if items else ""


def _figure(picture: Picture) -> str:
    data = base64.b64encode(picture.png.read_bytes()).decode()
    text = html.escape(picture.title)
    return (
        f"<figure id='{_anchor(picture.title)}'><div class='wide'><img alt=\"{text}\" style='min-width:"
        f'{15 * picture.panels}rem\' src="data:image/png;base64,{data}"></div>'
        f"<figcaption>{text} <code>{html.escape(picture.tag)}</code></figcaption></figure>"
    )


def _table(table: Table) -> str:
    head = "".join(f"<th scope='col'>{html.escape(cell)}</th>" for cell in table.header)
    body = "\n".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in table.rows)
    note = f"<p class='note'>{html.escape(table.note)}</p>" if table.note else ""
    return f"<div class='wide'><table><tr>{head}</tr>\n{body}</table></div>{note}"


def _cell(text: str) -> str:
    verdict = next((word for word in ("as the paper", "opposite") if text.startswith(word)), "")
    kind = f" class='{verdict.partition(' ')[0]}'" if verdict else ""
    return f"<td{kind}>{html.escape(text)}</td>"


def _anchor(title: str) -> str:
    words = "".join(c if c.isalnum() else " " for c in title.lower().replace("'", "")).split()
    return "-".join(words)


def _listed(names: Sequence[str]) -> str:
    marked = [f"<strong>{html.escape(name)}</strong>" for name in names]
    return " and ".join([", ".join(marked[:-1]), marked[-1]] if len(marked) > 1 else marked)
