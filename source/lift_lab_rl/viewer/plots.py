"""Curves of the last seconds of one environment."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from lift_lab.utils.errors import ConfigError, suggest

OFF = "off"
ALL = "all"
SECONDS = 10.0
"""Length of the curves in simulated seconds."""
MOST_CURVES = 12
"""More curves than these are not drawn together: choose one term."""
_COLOURS = (
    *("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b"),
    *("#e377c2", "#7f7f7f", "#bcbd22", "#17becf", "#393b79", "#ad494a"),
)
_HEIGHT_PX = 220

Terms = list[tuple[str, list[float]]]
"""Name of each term and its values."""


class LivePlot:
    """A chart of the reward terms, metrics, actions or observations of the environment that is selected.

    Only what is chosen is recorded, and only from the moment when it is chosen.
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
        """Terms of a group that can be chosen; "all" only if they are not too many."""
        if group == OFF:
            return [ALL]
        found = self._sources[group](self._env_id)
        count = sum(len(values) for _, values in found)
        return [*([ALL] if count <= MOST_CURVES else []), *(name for name, _ in found)]

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
        if self.chart is None or not self._fresh:
            return
        self._fresh = 0
        self.chart.data = self._data()

    def _data(self) -> tuple[np.ndarray, ...]:
        """Times and the values of each curve, oldest first."""
        order = np.roll(np.arange(self._length), -1 - self._steps % self._length)
        order = order[-max(2, min(self._steps, self._length)) :]
        return (self._times[order], *self._values[:, order])

    def _chosen(self) -> Terms:
        terms = self._sources[self.group](self._env_id)
        return terms if self.term == ALL else [one for one in terms if one[0] == self.term]

    def _restart(self) -> None:
        """Begin with empty curves, in a chart of their own."""
        if self.chart is not None:
            self.chart.remove()
            self.chart = None
        self._steps = self._fresh = 0
        if self.group == OFF:
            return
        self._names = []
        for name, values in self._chosen():
            self._names += [name] if len(values) == 1 else [f"{name}[{i}]" for i in range(len(values))]
        self._times = np.arange(self._length) * self._dt - self._length * self._dt
        self._values = np.full((len(self._names), self._length), np.nan)
        if self._folder is None:
            return
        series: list[dict[str, Any]] = [{"label": "time, s"}]
        for i, name in enumerate(self._names):
            series.append({"label": name, "stroke": _COLOURS[i % len(_COLOURS)], "width": 1.5})
        with self._folder:
            self.chart = self._gui.add_uplot(
                self._data(), tuple(series), scales={"x": {"time": False}}, height=_HEIGHT_PX, legend={"show": True}
            )
