"""Flags that the rsl_rl scripts share."""

from __future__ import annotations

from lift_lab.app import cli
from lift_lab.app.arguments import positive, task_parser

__all__ = ["make_parser", "positive"]


def make_parser(description: str | None) -> cli.Parser:
    """A parser with the flags of every rsl_rl script.

    Args:
        description: the script's docstring.
    """
    return task_parser(description, "rsl_rl_cfg_entry_point", "logs/rsl_rl")
