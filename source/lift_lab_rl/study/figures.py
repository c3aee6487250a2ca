"""Drawings of training curves: one panel a group side by side, the same axes, the paper's end values dashed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lift_lab.utils.errors import ConfigError

from .curves import Band, Group, smooth
from .paper import Figure

COLOURS = ("#c2399b", "#1597a5", "#e08a1e", "#5a6fd6", "#4f8a3a", "#8a5a3a")
"""Colours of the groups. The paper's baseline is magenta and its curriculum cyan."""


def draw(
    figure: Figure,
    groups: Sequence[Group],
    paper_ends: dict[str, float | None],
    smoothing: float = 0.9,
) -> Any | None:
    """One figure.

    Args:
        figure: what to draw.
        groups: one panel each; none whose runs lack the curve.
        paper_ends: the paper's end value, by label of the group that corresponds.
        smoothing: weight of the past in the solid line, in [0, 1).

    Returns:
        A matplotlib figure, or None if no group has the curve.

    Raises:
        ConfigError: matplotlib is not installed.
    """
    bands = [(k, group, group.band(figure.tags)) for k, group in enumerate(groups)]
    shown = [(k, group, band) for k, group, band in bands if band is not None]
    if not shown:
        return None
    canvas, drawing = _matplotlib()
    plot = drawing(figsize=(4.2 * len(shown), 3.0), layout="constrained")
    canvas(plot)
    panels = plot.subplots(1, len(shown), sharey=True, sharex=True, squeeze=False)[0]
    for panel, (k, group, band) in zip(panels, shown, strict=True):
        _panel(panel, band, group, COLOURS[k % len(COLOURS)], smoothing, paper_ends.get(group.label))
        panel.set_xlabel("environment steps (millions)")
    panels[0].set_ylabel(f"{figure.title}\n({figure.unit})" if figure.unit else figure.title, fontsize=9)
    return plot


def _panel(panel: Any, band: Band, group: Group, colour: str, smoothing: float, end: float | None) -> None:
    millions = band.steps / 1e6
    panel.fill_between(millions, band.low, band.high, color=colour, alpha=0.15, linewidth=0)
    panel.plot(millions, band.mean, color=colour, alpha=0.35, linewidth=0.7)
    panel.plot(millions, smooth(band.mean, smoothing), color=colour, linewidth=1.6)
    if end is not None:
        panel.axhline(end, color="#555555", linestyle="--", linewidth=0.9)
        panel.annotate(
            f"paper: {end:g}", (0.01, end), xycoords=("axes fraction", "data"), ha="left", va="bottom", fontsize=7
        )
    seeds = len(group.runs)
    label = group.label.replace("$", r"\$")  # no mathematics
    panel.set_title(f"{label} ({seeds} seed{'s' if seeds != 1 else ''})", fontsize=9)
    panel.grid(alpha=0.25, linewidth=0.5)
    panel.tick_params(labelsize=8)


def _matplotlib() -> tuple[Any, Any]:
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure as Drawing
    except ModuleNotFoundError as error:
        raise ConfigError("figures need matplotlib: pip install 'lift-lab[report]'") from error
    return FigureCanvasAgg, Drawing


def require_matplotlib() -> None:
    """Check that figures can be drawn.

    Raises:
        ConfigError: matplotlib is not installed.
    """
    _matplotlib()


def file_stem(figure: Figure) -> str:
    """Name of a figure's files, without an ending."""
    words = "".join(c if c.isalnum() else "_" for c in figure.title.lower().replace("'", ""))
    name = "_".join(word for word in words.split("_") if word)
    return f"figure_{figure.number:02}_{name}" if figure.number else name


def save(plot: Any, folder: Path, stem: str) -> list[Path]:
    """Write a figure as PNG and as PDF; returns the files. Equal figures give equal bytes."""
    folder.mkdir(parents=True, exist_ok=True)
    png, pdf = folder / f"{stem}.png", folder / f"{stem}.pdf"
    plot.savefig(png, dpi=130, metadata={"Software": None})
    plot.savefig(pdf, metadata={"CreationDate": None, "Producer": None, "Creator": None})
    return [png, pdf]
