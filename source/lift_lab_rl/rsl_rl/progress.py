"""Progress of a training run: a live panel on a terminal, one line per iteration elsewhere."""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass, field

from rich.console import Console, Group
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

_SECTIONS = ("Metrics", "Episode_Reward", "Curriculum", "Episode_Termination")
"""Groups of the environment's logs in the panel's order: a low terminal cuts the end."""
_TITLE_WIDTH, _NUMBER_WIDTH = 19, 9


@dataclass
class IterationReport:
    """One finished iteration."""

    iteration: int
    """Iterations finished so far."""
    total_iterations: int
    total_steps: int
    """Environment steps so far, all environments together."""
    steps: int
    """Environment steps of this iteration."""
    collect_s: float
    learn_s: float
    mean_reward: float | None = None
    """Mean return of the last episodes."""
    mean_length: float | None = None
    success: float | None = None
    learning_rate: float = 0.0
    action_std: float = 0.0
    entropy_coef: float = 0.0
    terms: dict[str, float] = field(default_factory=dict)
    """Episode logs: key -> mean of this iteration."""
    notes: list[str] = field(default_factory=list)
    """Lines for the user about what happened in it."""


class Progress:
    """Shows reports. Use as a context manager."""

    def __init__(self, title: str, console: Console | None = None):
        """Show nothing yet.

        Args:
            title: name of the run.
            console: where to; None for standard output.
        """
        self._title = title
        self._console = console if console is not None else Console()
        self._live: Live | None = None
        self._seconds: deque[float] = deque(maxlen=20)
        self._start = time.monotonic()

    def __enter__(self) -> Progress:
        self._start = time.monotonic()
        if self._console.is_terminal:
            self._live = Live(console=self._console, refresh_per_second=4, transient=False)
            self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        if self._live is not None:
            self._live.stop()
            self._live = None

    def note(self, text: str) -> None:
        """Show a message that stays."""
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)

    def show(self, report: IterationReport) -> None:
        """Show the newest iteration."""
        self._seconds.append(report.collect_s + report.learn_s)
        if self._live is not None:
            self._live.update(self._panel(report))
        else:
            self._console.print(self._line(report), markup=False, highlight=False, soft_wrap=True)
        for text in report.notes:
            self.note(text)

    def _time_left_s(self, report: IterationReport) -> float:
        per_iteration = sum(self._seconds) / len(self._seconds)
        return per_iteration * (report.total_iterations - report.iteration)

    def _line(self, r: IterationReport) -> str:
        width = len(str(r.total_iterations))
        seconds = r.collect_s + r.learn_s
        parts = [f"{r.iteration:>{width}}/{r.total_iterations}"]
        if r.success is not None:
            parts.append(f"success rate {r.success:.1%}")
        if r.mean_reward is not None and r.mean_length is not None:
            parts += [f"mean reward {r.mean_reward:.2f}", f"mean episode length {r.mean_length:.0f}"]
        parts += [
            f"{_count(r.total_steps)} steps",
            f"{r.steps / seconds:,.0f}/s (collect {r.collect_s:.2f} s, learn {r.learn_s:.2f} s)",
            f"left {clock(self._time_left_s(r))}",
        ]
        parts += [f"{key} {_number(value)}" for key, value in _important(r.terms)]
        return " | ".join(parts)

    def _panel(self, r: IterationReport) -> Panel:
        seconds = r.collect_s + r.learn_s
        times = f"{r.collect_s:.2f} s / {r.learn_s:.2f} s"
        elapsed, left = clock(time.monotonic() - self._start), clock(self._time_left_s(r))
        head = Table.grid(padding=(0, 2))
        for _ in range(4):
            head.add_column(justify="left")
        success = "-" if r.success is None else f"{r.success:.1%}"
        reward = "-" if r.mean_reward is None else f"{r.mean_reward:.2f}"
        length = "-" if r.mean_length is None else f"{r.mean_length:.1f}"
        head.add_row("success rate", success, "iteration", f"{r.iteration}/{r.total_iterations}")
        head.add_row("mean reward", reward, "steps", f"{r.total_steps:,}")
        head.add_row("mean episode length", length, "steps/s", f"{r.steps / seconds:,.0f}")
        head.add_row("learning rate", f"{r.learning_rate:.2g}", "collect / learn", times)
        head.add_row("mean std", f"{r.action_std:.2f}", "elapsed / left", f"{elapsed} / {left}")
        terms = [_section(name, entries, self._console.width - 4) for name, entries in _sections(r.terms)]
        bar = Table.grid(expand=True)
        bar.add_row(ProgressBar(total=r.total_iterations, completed=r.iteration))
        return Panel(Group(bar, head, Text(), *terms), title=self._title, title_align="left")


def clock(seconds: float) -> str:
    """Seconds as ``1:23:45`` or ``2:03``."""
    if not math.isfinite(seconds):
        return "?"
    minutes, second = divmod(round(max(0.0, seconds)), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02}:{second:02}" if hours else f"{minute}:{second:02}"


def _sections(terms: dict[str, float]) -> list[tuple[str, list[tuple[str, float]]]]:
    """Entries by the part of their key before the first slash, the most telling groups first."""
    found: dict[str, list[tuple[str, float]]] = {name: [] for name in _SECTIONS}
    for key, value in terms.items():
        section, _, name = key.partition("/")
        found.setdefault(section, []).append((name or key, value))
    return [(name, entries) for name, entries in found.items() if entries]


def _section(title: str, entries: list[tuple[str, float]], width: int) -> Table:
    """Entries under each other, in as many columns as there is room for."""
    longest = max(len(name) for name, _ in entries)
    columns = max(1, (width - _TITLE_WIDTH - 2) // (longest + _NUMBER_WIDTH + 4))
    table = Table.grid(padding=(0, 2, 0, 0))
    table.add_column(width=_TITLE_WIDTH)
    for _ in range(min(columns, len(entries))):
        table.add_column(width=longest, no_wrap=True)
        table.add_column(justify="right", width=_NUMBER_WIDTH, no_wrap=True)
    rows = -(-len(entries) // columns)
    for row in range(rows):
        cells = [cell for name, value in entries[row::rows] for cell in (Text(name, style="dim"), _number(value))]
        table.add_row(Text(title if row == 0 else ""), *cells)
    return table


def _important(terms: dict[str, float]) -> list[tuple[str, float]]:
    """The entries that a single line has room for: reward terms and what a curriculum changes."""
    return [(key, value) for key, value in terms.items() if key.startswith(("Episode_Reward/", "Curriculum/"))]


def _number(value: float) -> str:
    return f"{value:.2g}" if abs(value) < 0.01 else f"{value:.3f}" if abs(value) < 1000 else f"{value:.4g}"


def _count(value: int) -> str:
    if value < 10_000:
        return str(value)
    return f"{value / 1e6:.2f}M" if value >= 1_000_000 else f"{value / 1e3:.0f}k"
