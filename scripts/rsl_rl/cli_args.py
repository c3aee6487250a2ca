"""Flags that the rsl_rl scripts share."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence

from lift_lab.app import cli
from lift_lab.app.arguments import positive, task_parser

__all__ = ["add_checkpoint_args", "make_parser", "positive", "split_overrides"]

_OVERRIDE = re.compile(r"\+{0,2}(env|agent)[./].*=|~(env|agent)[./]")


def make_parser(description: str | None) -> cli.Parser:
    """A parser with the flags of every rsl_rl script.

    Args:
        description: the script's docstring.
    """
    return task_parser(description, "rsl_rl_cfg_entry_point", "logs/rsl_rl")


def add_checkpoint_args(parser: argparse.ArgumentParser) -> None:
    """Add the flags that say which policy acts."""
    parser.add_argument(
        "--checkpoint", type=str, default=None, help="path, latest (default), best, pretrained, or a file name"
    )
    parser.add_argument(
        "--load_run", type=str, default=None, help="regular expression of the run (default: the newest)"
    )


def split_overrides(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Overrides among the words of a command line, and the others: flags with several values would take both."""
    overrides = [word for word in words if _OVERRIDE.match(word)]
    return overrides, [word for word in words if word not in overrides]
