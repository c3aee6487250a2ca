"""Commands set by hand: sliders over the ranges that commands are drawn from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import torch

from lift_lab.utils.errors import ConfigError


@dataclass
class GoalRange:
    """One component of a command that a slider can set."""

    term: str
    """Name of the command term."""
    field: str
    """Field of its config's ranges, e.g. ``pos_x``."""
    low: float
    high: float

    @property
    def middle(self) -> float:
        """Half way."""
        return (self.low + self.high) / 2


class GoalControl:
    """Fixes what commands draw from, in all environments, and gives it back."""

    def __init__(self, command_manager: Any):
        """Find all ranges of two different numbers.

        Args:
            command_manager: of the environment.
        """
        self._manager = command_manager
        self.ranges: list[GoalRange] = []
        for name in command_manager.active_terms:
            ranges = getattr(command_manager.get_term(name).cfg, "ranges", None)
            for field, value in vars(ranges).items() if ranges is not None else ():
                if _is_range(value) and value[0] < value[1]:
                    self.ranges.append(GoalRange(name, field, float(value[0]), float(value[1])))

    def fix(self, values: list[float]) -> None:
        """Make every environment's command these values, now and whenever it is drawn.

        Args:
            values: one for each of :attr:`ranges`.

        Raises:
            ConfigError: a value is outside its range or no number.
        """
        for goal, value in zip(self.ranges, values, strict=True):
            if not goal.low <= value <= goal.high:
                raise ConfigError(f"{goal.term}.{goal.field}: {value} is not between {goal.low} and {goal.high}")
        for goal, value in zip(self.ranges, values, strict=True):
            self._write(goal, (value, value))
        self._draw()

    def release(self) -> None:
        """Draw from the task's default ranges again."""
        for goal in self.ranges:
            self._write(goal, (goal.low, goal.high))
        self._draw()

    def _write(self, goal: GoalRange, value: tuple[float, float]) -> None:
        setattr(self._manager.get_term(goal.term).cfg.ranges, goal.field, value)

    def _draw(self) -> None:
        for name in dict.fromkeys(goal.term for goal in self.ranges):
            term = self._manager.get_term(name)
            term.resample(torch.arange(term.num_envs, device=term.device))


def _is_range(value: Any) -> bool:
    return isinstance(value, (tuple, list)) and len(value) == 2 and all(isinstance(v, (int, float)) for v in value)
