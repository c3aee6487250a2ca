"""Tables of terms as plain text."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from io import StringIO

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text


def render_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A table in ASCII, its columns stretched in proportion where the title is the wider.

    Args:
        title: Line above the table.
        columns: Headings.
        rows: One sequence of cells a row, each shown by ``str``.
    """
    cells = [[str(cell) for cell in row] for row in rows]
    widths = [max(len(text) for text in column) for column in zip(columns, *cells, strict=True)]
    stretch = max(1.0, (len(title) + 2) / sum(width + 2 for width in widths))
    table = Table(box=box.ASCII)
    for heading, width in zip(columns, widths, strict=True):
        table.add_column(heading, min_width=int(width * stretch), no_wrap=True)
    for row in cells:
        table.add_row(*(Text(cell) for cell in row))
    stream = StringIO()
    Console(file=stream, width=10_000, color_system=None, force_terminal=False).print(table)
    return f"{title}\n{stream.getvalue()}"
