"""What a training run shows while it runs: a live panel on a terminal, one line an iteration elsewhere."""

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

    def _time_left_s(self, report: IterationReport) -> float:
        per_iteration = sum(self._seconds) / len(self._seconds)
        return per_iteration * (report.total_iterations - report.iteration)

    def _line(self, r: IterationReport) -> str:
        width = len(str(r.total_iterations))
        seconds = r.collect_s + r.learn_s
        parts = [
            f"{r.iteration:>{width}}/{r.total_iterations}",
            f"{_count(r.total_steps)} steps",
            f"{r.steps / seconds:,.0f}/s (collect {r.collect_s:.2f} s, learn {r.learn_s:.2f} s)",
            f"left {clock(self._time_left_s(r))}",
        ]
        if r.mean_reward is not None and r.mean_length is not None:
            parts += [f"reward {r.mean_reward:.2f}", f"length {r.mean_length:.0f}"]
        if r.success is not None:
            parts.append(f"success {r.success:.1%}")
        parts += [f"{_short(key)} {_number(value)}" for key, value in _important(r.terms)]
        return " | ".join(parts)

    def _panel(self, r: IterationReport) -> Panel:
        seconds = r.collect_s + r.learn_s
        head = Table.grid(padding=(0, 2))
        for _ in range(4):
            head.add_column(justify="left")
        head.add_row("iteration", f"{r.iteration}/{r.total_iterations}", "steps", f"{r.total_steps:,}")
        head.add_row(
            "steps/s", f"{r.steps / seconds:,.0f}", "collect / learn", f"{r.collect_s:.2f} s / {r.learn_s:.2f} s"
        )
        elapsed = clock(time.monotonic() - self._start)
        head.add_row("elapsed", elapsed, "time left", clock(self._time_left_s(r)))
        reward = "-" if r.mean_reward is None else f"{r.mean_reward:.2f}"
        length = "-" if r.mean_length is None else f"{r.mean_length:.1f}"
        head.add_row("mean reward", reward, "episode length", length)
        success = "-" if r.success is None else f"{r.success:.1%}"
        head.add_row("success", success, "rate / action std", f"{r.learning_rate:.2g} / {r.action_std:.2f}")
        columns = max(1, self._console.width // 64)
        terms = Table.grid(padding=(0, 2))
        entries = [(Text(key, style="dim"), _number(value)) for key, value in r.terms.items()]
        rows = -(-len(entries) // columns)
        for row in range(rows):
            terms.add_row(*(cell for entry in entries[row::rows] for cell in entry))
        bar = Table.grid(expand=True)
        bar.add_row(ProgressBar(total=r.total_iterations, completed=r.iteration))
        return Panel(Group(bar, head, Text(), terms), title=self._title, title_align="left")


def clock(seconds: float) -> str:
    """Seconds as ``1:23:45`` or ``2:03``."""
    if not math.isfinite(seconds):
        return "?"
    minutes, second = divmod(round(max(0.0, seconds)), 60)
    hours, minute = divmod(minutes, 60)
    return f"{hours}:{minute:02}:{second:02}" if hours else f"{minute}:{second:02}"


def _important(terms: dict[str, float]) -> list[tuple[str, float]]:
    """The entries that a single line has room for: reward terms and what a curriculum changes."""
    return [(key, value) for key, value in terms.items() if key.startswith(("Episode_Reward/", "Curriculum/"))]


def _short(key: str) -> str:
    return key.partition("/")[2] if key.startswith("Episode_Reward/") else key


def _number(value: float) -> str:
    return f"{value:.2g}" if abs(value) < 0.01 else f"{value:.3f}" if abs(value) < 1000 else f"{value:.4g}"


def _count(value: int) -> str:
    return f"{value / 1e6:.2f}M" if value >= 1_000_000 else f"{value / 1e3:.0f}k"
