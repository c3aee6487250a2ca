"""Curves of the last seconds of one environment."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np

from lift_lab.utils.errors import ConfigError, suggest

OFF = "off"
ALL = "all"
SECONDS = 10.0
"""Length of the curves in simulated seconds."""
TOGETHER = ("rewards", "actions")
"""Groups whose terms have one unit, so that all of them fit into one chart."""
_COLOURS = (
    *("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b"),
    *("#e377c2", "#7f7f7f", "#bcbd22", "#17becf", "#393b79", "#ad494a"),
)
_HEIGHT_PX = 220

Terms = list[tuple[str, list[float]]]
"""Name of each term and its values."""


class LivePlot:
    """A chart of the reward terms, metrics, actions or observations of the environment that is selected.

    Only chosen quantities are recorded, from the moment when they are chosen.
    """

    def __init__(self, env: Any):
        """Record nothing yet.

        Args:
            env: the environment without wrappers.
        """
        managers = {
            "rewards": env.reward_manager,
            "metrics": env.metrics_manager,
            "actions": env.action_manager,
            "observations": env.observation_manager,
        }
        self._sources: dict[str, Callable[[int], Terms]] = {
            name: manager.get_active_iterable_terms for name, manager in managers.items() if manager.active_terms
        }
        self._dt = env.step_dt
        self._length = max(2, round(SECONDS / env.step_dt))
        self._gui: Any = None
        self._folder: Any = None
        self.chart: Any = None
        """Handle of the chart; None while nothing is plotted."""
        self.group = OFF
        """What is plotted."""
        self.term = ALL
        """Which of its terms."""
        self._env_id = 0
        self._steps = 0
        self._fresh = 0
        self._names: list[str] = []
        self._times = np.zeros(0)
        self._values = np.zeros((0, 0))

    @property
    def groups(self) -> list[str]:
        """Quantities that can be plotted."""
        return [OFF, *self._sources]

    def terms(self, group: str) -> list[str]:
        """Terms of a group that can be chosen, and "all" where they have one unit."""
        if group == OFF:
            return [ALL]
        return [*([ALL] if group in TOGETHER else []), *(name for name, _ in self._sources[group](self._env_id))]

    def put_into(self, gui: Any, folder: Any) -> None:
        """Draw the chart in a folder of the page from now on."""
        self._gui, self._folder = gui, folder

    def choose(self, group: str, term: str | None = None) -> None:
        """Plot something else.

        Args:
            group: one of :attr:`groups`.
            term: one of :meth:`terms`; None for the first.

        Raises:
            ConfigError: there is no such group or term.
        """
        if group not in self.groups:
            raise ConfigError(f"cannot plot '{group}'; {suggest(group, self.groups)}")
        terms = self.terms(group)
        if term is not None and term not in terms:
            raise ConfigError(f"cannot plot '{term}' of {group}; {suggest(term, terms)}")
        self.group, self.term = group, terms[0] if term is None else term
        self._restart()

    def select(self, env_id: int) -> None:
        """Plot another environment."""
        self._env_id = env_id
        self._restart()

    def record(self) -> None:
        """Take the values after one environment step."""
        if self.group == OFF:
            return
        self._steps += 1
        row = [value for _, values in self._chosen() for value in values]
        if len(row) != len(self._names):  # a term has changed its size
            self._restart()
        at = self._steps % self._length
        self._times[at], self._values[:, at] = self._steps * self._dt, row
        self._fresh += 1

    def push(self) -> None:
        """Send the curves to the page if there is anything new."""
        if self._folder is None or not self._fresh:
            return
        self._fresh = 0
        data = self._data()
        if len(data[0]) < 2:  # no curve yet
            return
        if self.chart is None:
            with self._folder:
                self.chart = self._gui.add_uplot(
                    data, self._series(), scales={"x": {"time": False}}, height=_HEIGHT_PX, legend={"show": True}
                )
        else:
            self.chart.data = data
            self.chart.visible = True

    def _series(self) -> tuple[dict[str, Any], ...]:
        """Label and look of each curve."""
        colours = itertools.cycle(_COLOURS)
        curves = [
            {"label": name, "stroke": colour, "width": 1.5} for name, colour in zip(self._names, colours, strict=False)
        ]
        return ({"label": "time, s"}, *curves)

    def _data(self) -> tuple[np.ndarray, ...]:
        """Times and the values of each curve, oldest first, without times at which a value is no number."""
        order = np.roll(np.arange(self._length), -1 - self._steps % self._length)
        order = order[self._length - min(self._steps, self._length) :]
        order = order[np.isfinite(self._values[:, order]).all(axis=0)]
        return (self._times[order], *self._values[:, order])

    def _chosen(self) -> Terms:
        terms = self._sources[self.group](self._env_id)
        return terms if self.term == ALL else [one for one in terms if one[0] == self.term]

    def _restart(self) -> None:
        """Begin with empty curves, in a new chart if there are others."""
        self._steps = self._fresh = 0
        chosen = [] if self.group == OFF else self._chosen()
        before, self._names = self._names, []
        for name, values in chosen:
            self._names += [name] if len(values) == 1 else [f"{name}[{i}]" for i in range(len(values))]
        self._times = np.zeros(self._length)
        self._values = np.full((len(self._names), self._length), np.nan)
        if self.chart is None:
            return
        if self._names != before:
            self.chart.remove()
            self.chart = None
        else:
            self.chart.visible = False  # until there are two points
